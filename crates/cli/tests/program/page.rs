//! The page in a browser: no error, no request, ink in every figure, a view that turns, light and dark, narrow, wide and printed,
//! and nothing that an accessibility checker objects to.
//!
//! Skipped, and said so, where no Chromium is installed; the checker alone where npm cannot fetch it.

use crate::folder::Folder;
use crate::report::{EVIL, discovered};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// The accessibility checker, pinned.
const AXE: &str = "4.10.3";

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
  function hovered(canvas) {
    var box = canvas.getBoundingClientRect(), x, y;
    for (x = 0; x < box.width; x += 6) for (y = 0; y < box.height; y += 6) {
      canvas.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + x, clientY: box.top + y }));
      if (canvas.title) return canvas.title;
    }
    return "";
  }
  var svgs = Array.from(document.querySelectorAll("figure svg"));
  var answer = {
    turned: canvas.dataset.azimuth !== before, ink: ink(canvas), hovered: [hovered(canvas), hovered(document.getElementById("robot"))],
    figures: svgs.length,
    empty: svgs.filter(function (s) { var b = s.getBBox(); return !(b.width > 20 && b.height > 20) || s.querySelectorAll("path,rect").length < 2; }).length,
    nameless: Array.from(document.querySelectorAll("svg,canvas")).filter(function (s) { return !s.getAttribute("aria-label"); }).length,
    requests: performance.getEntriesByType("resource").filter(function (e) { return !e.name.startsWith("data:"); }).map(function (e) { return e.name; }),
    small: svgs.filter(function (s) { return s.getBoundingClientRect().width > 1 && s.getBoundingClientRect().width * 8 < s.viewBox.baseVal.width * 5; }).length,
    width: innerWidth, wanted: document.documentElement.scrollWidth,
    dark: matchMedia("(prefers-color-scheme: dark)").matches, paper: light("--paper"),
    contrast: Math.min(contrast("--ink", "--paper"), contrast("--soft", "--paper"), contrast("--soft", "--tile"), contrast("--after", "--paper"), contrast("--before", "--paper"), contrast("--good", "--paper")),
    links: Array.from(document.querySelectorAll("a[href^='#']")).filter(function (a) { return !document.getElementById(a.hash.slice(1)); }).length
  };
  function say() { var holder = document.createElement("pre"); holder.id = "probe"; holder.textContent = JSON.stringify(answer); document.body.appendChild(holder); }
  if (!window.axe) { say(); return; }
  axe.run(document, { resultTypes: ["violations"] }).then(function (found) {
    answer.passes = found.passes.length;
    answer.violations = found.violations.map(function (v) { return v.id + ": " + v.nodes[0].html.slice(0, 200) + " " + v.nodes[0].failureSummary; });
    say();
  });
});
</script></body>"#;

pub fn browser() -> Option<&'static str> {
    ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|out| out.status.success()))
}

/// The checker's script, fetched once by npm into the tests' own folder; none, and said, where that fails.
pub fn axe() -> Option<String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("axe");
    let script = folder.join("node_modules/axe-core/axe.min.js");
    let read = || std::fs::read_to_string(&script).ok().filter(|text| text.contains(&format!("axe v{AXE}")));
    let fetch = || {
        std::fs::create_dir_all(&folder).ok()?;
        Command::new("npm")
            .args([
                "install",
                "--no-save",
                "--ignore-scripts",
                "--no-audit",
                "--no-fund",
                "--fetch-retries=0",
            ])
            .args(["--fetch-timeout=30000", "--prefix"])
            .arg(&folder)
            .arg(format!("axe-core@{AXE}"))
            .output()
            .ok()
            .filter(|out| out.status.success())
    };
    let found = read().or_else(|| fetch().and_then(|_| read()));
    if found.is_none() {
        println!("SKIPPED: npm could not fetch axe-core {AXE}; the page was not checked for accessibility");
    }
    found.map(|script| format!("<script>{script}</script>"))
}

/// Chromium without a window, on a page of the folder.
pub fn chromium(browser: &str, folder: &Folder, page: &str, arguments: &[String]) -> (String, String) {
    let out = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"])
        .args(["--disable-background-networking", "--virtual-time-budget=20000"])
        .arg(format!("--user-data-dir={}", folder.file("profile").display()))
        .args(arguments)
        .arg(format!("file://{}", folder.file(page).display()))
        .output()
        .unwrap();
    let log = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(!log.contains("CONSOLE"), "{log}");
    (String::from_utf8_lossy(&out.stdout).into_owned(), log)
}

/// What the page says about itself; `printed`: as on paper, whose style is then that of the screen.
fn asked(browser: &str, folder: &Folder, axe: &str, width: u32, dark: bool, printed: bool) -> Value {
    let mut page = folder.read("page/index.html").replace("</body>", &format!("{axe}{PROBE}"));
    if printed {
        page = page.replace("@media print", "@media all");
    }
    folder.write("page/probed.html", &page);
    let (dom, log) = chromium(
        browser,
        folder,
        "page/probed.html",
        &[
            "--dump-dom".into(),
            format!("--window-size={width},900"),
            format!("--blink-settings=preferredColorScheme={}", u8::from(!dark)),
        ],
    );
    let (_, rest) =
        dom.split_once("<pre id=\"probe\">").unwrap_or_else(|| panic!("no answer of the page:\n{log}"));
    let answer =
        rest.split_once("</pre>").unwrap().0.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&answer).unwrap()
}

#[test]
fn the_page_in_a_browser() {
    let Some(browser) = browser() else {
        println!("SKIPPED: no Chromium is installed; the page was not looked at in a browser");
        return;
    };
    let axe = axe().unwrap_or_default();
    // Names that would run where they are not escaped would also show as errors and requests.
    let folder = discovered(EVIL);
    // A sheet of A4 with margins of 10 mm is 718 px wide.
    let windows = [(360, true, false), (718, true, true), (1920, false, false), (718, false, true)];
    for &(width, dark, printed) in if cfg!(feature = "slow") { &windows[..] } else { &windows[..2] } {
        let seen = asked(browser, &folder, &axe, width, dark, printed);
        let number = |key: &str| seen[key].as_f64().unwrap();
        assert_eq!(seen["turned"], true, "{seen}");
        let hovered = |k: usize| seen["hovered"][k].as_str().unwrap_or_default();
        assert!(hovered(0).starts_with("row ") && hovered(0).ends_with(" mm"), "{seen}");
        assert!(hovered(1).contains(", row ") && hovered(1).ends_with(" mm"), "{seen}");
        assert!(number("ink") > 500.0 && number("figures") > 6.0, "{seen}");
        for none in ["empty", "nameless", "links", "small"] {
            assert_eq!(seen[none], 0, "{none}: {seen}");
        }
        assert_eq!(seen["requests"], serde_json::json!([]), "{seen}");
        assert!(number("wanted") <= number("width") + 1.0, "the page is wider than the window: {seen}");
        assert_eq!(seen["dark"], dark, "{seen}");
        // Paper is white, whatever the screen likes.
        assert_eq!(number("paper") < 0.1, dark && !printed, "{seen}");
        assert!(number("contrast") >= 4.5, "{seen}");
        if !axe.is_empty() {
            assert_eq!(seen["violations"], serde_json::json!([]), "{width} px, dark {dark}");
            assert!(number("passes") > 10.0, "the checker looked at little: {seen}");
        }
    }
    let pdf = folder.file("page.pdf");
    let print = [format!("--print-to-pdf={}", pdf.display())];
    chromium(browser, &folder, "page/index.html", &print);
    let text = String::from_utf8_lossy(&std::fs::read(pdf).unwrap()).into_owned();
    let sheets = text.matches("/Type /Page").count() - text.matches("/Type /Pages").count();
    assert!((3..40).contains(&sheets), "{sheets} sheets");
}
