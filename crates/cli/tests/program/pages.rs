//! The pages of every verb in a browser: narrow and wide, nothing too wide, no request, no objection of the accessibility checker; the summary
//! prints to one sheet.

use crate::folder::Folder;
use crate::page::{axe, browser, chromium};
use serde_json::Value;

/// Asks the page about its width, its requests and, where the checker is there, its violations.
const PROBE: &str = r#"<script>
window.addEventListener("load", function () {
  var answer = {
    width: innerWidth, wanted: document.documentElement.scrollWidth,
    nameless: Array.from(document.querySelectorAll("svg,canvas")).filter(function (s) { return !s.getAttribute("aria-label"); }).length,
    requests: performance.getEntriesByType("resource").filter(function (e) { return !e.name.startsWith("data:"); }).length,
    turned: true, violations: []
  };
  var canvas = document.getElementById("robot");
  if (canvas) {
    var before = canvas.dataset.azimuth;
    canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight" }));
    answer.turned = canvas.dataset.azimuth !== before;
  }
  function say() { var holder = document.createElement("pre"); holder.id = "probe"; holder.textContent = JSON.stringify(answer); document.body.appendChild(holder); }
  if (!window.axe) { say(); return; }
  axe.run(document, { resultTypes: ["violations"] }).then(function (found) {
    answer.violations = found.violations.map(function (v) { return v.id + ": " + v.nodes[0].html.slice(0, 200); });
    say();
  });
});
</script></body>"#;

pub fn asked(browser: &str, folder: &Folder, page: &str, axe: &str, width: u32) -> Value {
    folder.write("probed.html", &folder.read(page).replace("</body>", &format!("{axe}{PROBE}")));
    let arguments = ["--dump-dom".into(), format!("--window-size={width},900")];
    let (dom, log) = chromium(browser, folder, "probed.html", &arguments);
    let (_, rest) =
        dom.split_once("<pre id=\"probe\">").unwrap_or_else(|| panic!("{page}: no answer:\n{log}"));
    let text = rest.split_once("</pre>").unwrap().0;
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&text).unwrap()
}

#[test]
fn every_verb_has_a_page() {
    let folder = Folder::with_data();
    folder.write("head.toml", "[certificate]\noperator = \"<b>N. N.</b>\"\nserial = \"17\"\n");
    let fit =
        ["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json", "--report", "i"];
    folder.run(&[&fit[..], &["--certificate", "head.toml"]].concat()).ended(0);
    folder.write("t.csv", "x[mm],y[mm],z[mm]\n400,100,300\n9000,0,0\n");
    for run in [
        &["compensate", "--poses", "t.csv", "--out", "c.csv"][..],
        &["map", "--points", "3", "--out", "m.csv"],
        &["plan", "--count", "6", "--out", "plan.csv"],
        &["predict", "--data", "data.csv", "--out", "p.csv"],
    ] {
        folder.run(&[run, &["--fit", "fit.json", "--report", run[0]]].concat()).ended(0);
        // A page's run can be repeated.
        folder.run(&["verify", &format!("{}/run.json", run[0])]).ended(0);
    }
    folder.run("verify i/run.json").ended(0);
    let head = folder.read("i/index.html");
    assert!(head.contains("<dt>operator</dt><dd>&lt;b&gt;N. N.&lt;/b&gt;</dd>"), "{}", &head[..3000]);
    let run = folder.json("i/run.json");
    let robot = &run["inputs"][0]["sha256"].as_str().unwrap()[..8];
    assert!(head.contains(&format!("<dt>files read</dt><dd>robot.toml ({robot}), ")), "{}", &head[..3000]);
    let Some(browser) = browser() else {
        println!("SKIPPED: no Chromium is installed; the pages were not looked at in a browser");
        return;
    };
    let axe = axe().unwrap_or_default();
    // A start of the browser takes a second: one of each sort of page, and the rest in the slow tests.
    let all = [
        ("i/index.html", 360),
        ("compensate/index.html", 360),
        ("map/index.html", 1280),
        ("i/index.html", 1280),
        ("i/summary.html", 360),
        ("map/index.html", 360),
        ("plan/index.html", 360),
        ("predict/index.html", 1280),
    ];
    for &(page, width) in if cfg!(feature = "slow") { &all[..] } else { &all[..3] } {
        let seen = asked(browser, &folder, page, &axe, width);
        let number = |key: &str| seen[key].as_f64().unwrap();
        assert!(number("wanted") <= number("width") + 1.0, "{page} is wider than the window: {seen}");
        assert_eq!(
            (seen["requests"].as_u64(), seen["nameless"].as_u64()),
            (Some(0), Some(0)),
            "{page}: {seen}"
        );
        assert_eq!(seen["violations"], serde_json::json!([]), "{page}, {width} px");
        assert_eq!(seen["turned"], true, "{page}");
    }
    let pdf = folder.file("summary.pdf");
    let summaries = ["i/summary.html", "compensate/summary.html", "map/summary.html"];
    for page in if cfg!(feature = "slow") { &summaries[..] } else { &summaries[..1] } {
        chromium(browser, &folder, page, &[format!("--print-to-pdf={}", pdf.display())]);
        let text = String::from_utf8_lossy(&std::fs::read(&pdf).unwrap()).into_owned();
        let sheets = text.matches("/Type /Page").count() - text.matches("/Type /Pages").count();
        assert_eq!(sheets, 1, "{page}");
    }
}
