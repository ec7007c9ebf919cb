"use strict";
// Paper has nothing to click on: what is folded is printed.
(function () {
  var opened = [];
  window.addEventListener("beforeprint", function () {
    opened = Array.prototype.filter.call(document.querySelectorAll("details"), function (d) { return !d.open; });
    opened.forEach(function (d) { d.open = true; });
  });
  window.addEventListener("afterprint", function () { opened.forEach(function (d) { d.open = false; }); });
})();
// The words of the mark at a pointer: x, y and words each.
function nearest(marks, canvas, e) {
  var box = canvas.getBoundingClientRect(), words = "", least = 10;
  marks.forEach(function (m) { var d = Math.hypot(m[0] - e.clientX + box.left, m[1] - e.clientY + box.top); if (d < least) { least = d; words = m[2]; } });
  return words;
}
(function () {
  var holder = document.getElementById("space-data"), canvas = document.getElementById("space");
  if (!holder || !canvas) return;
  var data = JSON.parse(holder.textContent), ctx = canvas.getContext("2d");
  var azimuth = 0.6, height = 0.45, mode = "errors", marks = [];
  function colour(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }
  function mix(t) { return "hsl(" + Math.round(210 - 190 * t) + " 75% " + (dark() ? 62 : 44) + "%)"; }
  function dark() { return matchMedia("(prefers-color-scheme: dark)").matches && !matchMedia("print").matches; }
  function draw() {
    var box = canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1, stacked = box.width < 560;
    var many = data.clouds.length, w = Math.max(200, box.width), h = stacked ? w * many : w * 0.5;
    canvas.width = Math.round(w * ratio); canvas.height = Math.round(h * ratio);
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.fillStyle = colour("--paper"); ctx.fillRect(0, 0, w, h);
    var side = stacked ? w : w / 2;
    var first = many === 1 && !stacked ? w / 4 : 0;
    marks = [];
    data.clouds.forEach(function (cloud, k) {
      panel(stacked ? 0 : first + k * side, stacked ? k * side : 0, side, data.titles[k], cloud, data.colours[k]);
    });
    canvas.dataset.azimuth = azimuth.toFixed(3); canvas.dataset.height = height.toFixed(3);
  }
  function panel(left, top, side, title, list, name) {
    var cx = left + side / 2, cy = top + side / 2 + 8, errors = mode === "errors";
    var reach = errors ? data.reach : data.size, scale = 0.42 * side / reach, mid = errors ? [0, 0, 0] : data.middle;
    var ca = Math.cos(azimuth), sa = Math.sin(azimuth), ch = Math.cos(height), sh = Math.sin(height);
    function at(x, y, z) {
      var d = x * sa + y * ca;
      return [cx + (x * ca - y * sa) * scale, cy - (z * ch - d * sh) * scale, d * ch + z * sh];
    }
    ctx.font = "600 13px system-ui, sans-serif"; ctx.fillStyle = colour("--ink"); ctx.textAlign = "center";
    ctx.fillText(title, cx, top + 18);
    ctx.font = "12px system-ui, sans-serif"; ctx.strokeStyle = colour("--soft"); ctx.fillStyle = colour("--soft"); ctx.lineWidth = 1;
    [[1, 0, 0, "x"], [0, 1, 0, "y"], [0, 0, 1, "z"]].forEach(function (a) {
      var o = at(0, 0, 0), e = at(a[0] * reach * 0.95, a[1] * reach * 0.95, a[2] * reach * 0.95);
      ctx.globalAlpha = 0.6; ctx.beginPath(); ctx.moveTo(o[0], o[1]); ctx.lineTo(e[0], e[1]); ctx.stroke(); ctx.globalAlpha = 1;
      ctx.fillText(a[3], e[0] + 6, e[1]);
    });
    var order = [], i, p;
    for (i = 0; i < list.length; i += 3) {
      var v = errors ? list : data.place;
      p = at(v[i] - mid[0], v[i + 1] - mid[1], v[i + 2] - mid[2]);
      p.push(Math.sqrt(list[i] * list[i] + list[i + 1] * list[i + 1] + list[i + 2] * list[i + 2]));
      order.push(p); marks.push([p[0], p[1], "row " + data.rows[i / 3] + ": " + p[3].toPrecision(3) + " mm"]);
    }
    order.sort(function (a, b) { return b[2] - a[2]; });
    ctx.fillStyle = colour(name); ctx.globalAlpha = errors ? 0.55 : 0.8;
    order.forEach(function (q) {
      if (!errors) ctx.fillStyle = mix(Math.min(1, q[3] / data.reach));
      ctx.beginPath(); ctx.arc(q[0], q[1], errors ? 2 : 2.4, 0, 6.3); ctx.fill();
    });
    ctx.globalAlpha = 1;
    if (errors && data.limit) {
      ctx.strokeStyle = colour("--ink"); ctx.lineWidth = 0.8; ctx.globalAlpha = 0.55;
      for (var k = -2; k <= 2; k++) ring(at, function (t) { var b = k * Math.PI / 6; return [Math.cos(b) * Math.cos(t), Math.cos(b) * Math.sin(t), Math.sin(b)]; });
      for (k = 0; k < 4; k++) ring(at, function (t) { var b = k * Math.PI / 4; return [Math.cos(t) * Math.cos(b), Math.cos(t) * Math.sin(b), Math.sin(t)]; });
      ctx.globalAlpha = 1;
    }
    ctx.fillStyle = colour("--soft"); ctx.textAlign = "center";
    ctx.fillText(errors ? data.words : data.placeWords, cx, top + side - 6);
  }
  function ring(at, f) {
    ctx.beginPath();
    for (var n = 0; n <= 48; n++) { var u = f(n * Math.PI / 24), p = at(u[0] * data.limit, u[1] * data.limit, u[2] * data.limit); if (n) ctx.lineTo(p[0], p[1]); else ctx.moveTo(p[0], p[1]); }
    ctx.stroke();
  }
  function turn(a, b) { azimuth += a; height = Math.max(-1.5, Math.min(1.5, height + b)); draw(); }
  var from = null;
  canvas.addEventListener("pointerdown", function (e) { from = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener("pointermove", function (e) { if (!from) canvas.title = nearest(marks, canvas, e); });
  canvas.addEventListener("pointermove", function (e) { if (from) { turn((e.clientX - from[0]) * 0.01, (e.clientY - from[1]) * 0.01); from = [e.clientX, e.clientY]; } });
  ["pointerup", "pointercancel"].forEach(function (n) { canvas.addEventListener(n, function () { from = null; }); });
  canvas.addEventListener("keydown", function (e) {
    var by = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[e.key];
    if (by) { turn(by[0], by[1]); e.preventDefault(); }
  });
  Array.prototype.forEach.call(document.querySelectorAll("button[data-mode]"), function (button) {
    button.addEventListener("click", function () {
      mode = button.dataset.mode;
      Array.prototype.forEach.call(document.querySelectorAll("button[data-mode]"), function (b) { b.setAttribute("aria-pressed", String(b === button)); });
      draw();
    });
  });
  window.addEventListener("resize", draw); window.addEventListener("beforeprint", draw); window.addEventListener("afterprint", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
})();
