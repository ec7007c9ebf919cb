//! The page in a browser: no error, no request, ink in every figure, a view that turns, light and dark, narrow and wide.
//!
//! Skipped, and said so, where no Chromium is installed.

use crate::folder::Folder;
use crate::report::discovered;
use serde_json::Value;
use std::process::Command;

/// Asks the page about itself and writes the answer into it.
const PROBE: &str = r#"<script>
window.addEventListener("load", function () {
  function ink(canvas) {
    var all = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data, n = 0;
    for (var i = 0; i < all.length; i += 4) if (all[i] !== all[0] || all[i + 1] !== all[1] || all[i + 2] !== all[2]) n++;
    return n;
  }
  function light(name) {
    var c = document.createElement("canvas").getContext("2d");
    c.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
    c.fillRect(0, 0, 1, 1);
    var p = Array.from(c.getImageData(0, 0, 1, 1).data).slice(0, 3).map(function (v) { v /= 255; return v <= 0.03928 ? v / 12.92 : Math.pow((v + 0.055) / 1.055, 2.4); });
    return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
  }
  function contrast(a, b) { var x = light(a), y = light(b); return (Math.max(x, y) + 0.05) / (Math.min(x, y) + 0.05); }
  var canvas = document.getElementById("space"), before = canvas.dataset.azimuth;
  canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight" }));
  var svgs = Array.from(document.querySelectorAll("figure svg"));
  var answer = {
    turned: canvas.dataset.azimuth !== before, ink: ink(canvas),
    figures: svgs.length,
    empty: svgs.filter(function (s) { var b = s.getBBox(); return !(b.width > 20 && b.height > 20) || s.querySelectorAll("path,rect").length < 2; }).length,
    nameless: Array.from(document.querySelectorAll("svg,canvas")).filter(function (s) { return !s.getAttribute("aria-label"); }).length,
    requests: performance.getEntriesByType("resource").filter(function (e) { return !e.name.startsWith("data:"); }).map(function (e) { return e.name; }),
    width: innerWidth, wanted: document.documentElement.scrollWidth,
    dark: matchMedia("(prefers-color-scheme: dark)").matches, paper: light("--paper"),
    contrast: Math.min(contrast("--ink", "--paper"), contrast("--soft", "--paper"), contrast("--soft", "--tile"), contrast("--after", "--paper"), contrast("--before", "--paper"), contrast("--good", "--paper")),
    links: Array.from(document.querySelectorAll("a[href^='#']")).filter(function (a) { return !document.getElementById(a.hash.slice(1)); }).length
  };
  var holder = document.createElement("pre"); holder.id = "probe"; holder.textContent = JSON.stringify(answer); document.body.appendChild(holder);
});
</script></body>"#;

fn browser() -> Option<&'static str> {
    ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|out| out.status.success()))
}

fn asked(browser: &str, folder: &Folder, width: u32, dark: bool) -> Value {
    let page = folder.read("page/index.html").replace("</body>", PROBE);
    folder.write("page/probed.html", &page);
    let out = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom", "--enable-logging=stderr"])
        .args(["--disable-background-networking", "--virtual-time-budget=3000"])
        .arg(format!("--user-data-dir={}", folder.file("profile").display()))
        .arg(format!("--window-size={width},900"))
        .arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!dark)))
        .arg(format!("file://{}", folder.file("page/probed.html").display()))
        .output()
        .unwrap();
    let log = String::from_utf8_lossy(&out.stderr);
    assert!(!log.contains("CONSOLE"), "{log}");
    let dom = String::from_utf8_lossy(&out.stdout);
    let (_, rest) =
        dom.split_once("<pre id=\"probe\">").unwrap_or_else(|| panic!("no answer of the page:\n{log}"));
    let answer =
        rest.split_once("</pre>").unwrap().0.replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">");
    serde_json::from_str(&answer).unwrap()
}

#[test]
fn the_page_in_a_browser() {
    let Some(browser) = browser() else {
        println!("SKIPPED: no Chromium is installed; the page was not looked at in a browser");
        return;
    };
    // Names that would run where they are not escaped would also show as errors and requests.
    let folder = discovered("<img src=x onerror=alert(1)>", "j1</script>");
    for (width, dark) in [(360, false), (360, true), (1920, false), (1920, true)] {
        let seen = asked(browser, &folder, width, dark);
        let number = |key: &str| seen[key].as_f64().unwrap();
        assert_eq!(seen["turned"], true, "{seen}");
        assert!(number("ink") > 500.0 && number("figures") > 6.0, "{seen}");
        for none in ["empty", "nameless", "links"] {
            assert_eq!(seen[none], 0, "{none}: {seen}");
        }
        assert_eq!(seen["requests"], serde_json::json!([]), "{seen}");
        assert!(number("wanted") <= number("width") + 1.0, "the page is wider than the window: {seen}");
        assert_eq!(seen["dark"], dark, "{seen}");
        assert_eq!(number("paper") < 0.1, dark, "{seen}");
        assert!(number("contrast") >= 4.5, "{seen}");
    }
}
