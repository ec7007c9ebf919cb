(function () {
  var holder = document.getElementById("robot-data"), canvas = document.getElementById("robot");
  if (!holder || !canvas) return;
  var data = JSON.parse(holder.textContent), ctx = canvas.getContext("2d");
  var slider = document.getElementById("robot-pose"), name = document.getElementById("robot-name");
  var azimuth = 0.6, height = 0.35, marks = [];
  function colour(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }
  function draw() {
    var box = canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
    var w = Math.max(200, box.width), h = Math.min(w * 0.8, 620), chosen = Number(slider.value);
    canvas.width = Math.round(w * ratio); canvas.height = Math.round(h * ratio);
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.fillStyle = colour("--paper"); ctx.fillRect(0, 0, w, h);
    var scale = 0.48 * Math.min(w, h) / data.size, mid = data.middle;
    var ca = Math.cos(azimuth), sa = Math.sin(azimuth), ch = Math.cos(height), sh = Math.sin(height);
    function at(x, y, z) {
      x -= mid[0]; y -= mid[1]; z -= mid[2];
      var d = x * sa + y * ca;
      return [w / 2 + (x * ca - y * sa) * scale, h / 2 - (z * ch - d * sh) * scale];
    }
    function line(list) {
      ctx.beginPath();
      for (var i = 0; i < list.length; i += 3) { var p = at(list[i], list[i + 1], list[i + 2]); if (i) ctx.lineTo(p[0], p[1]); else ctx.moveTo(p[0], p[1]); }
      ctx.stroke();
    }
    function arrow(from, to) {
      var dx = to[0] - from[0], dy = to[1] - from[1], n = Math.hypot(dx, dy), head = Math.min(7, 0.4 * n);
      if (!(n > 0.5)) return;
      dx /= n; dy /= n;
      ctx.beginPath(); ctx.moveTo(from[0], from[1]); ctx.lineTo(to[0], to[1]);
      ctx.moveTo(to[0] - head * (dx - 0.5 * dy), to[1] - head * (dy + 0.5 * dx)); ctx.lineTo(to[0], to[1]);
      ctx.lineTo(to[0] - head * (dx + 0.5 * dy), to[1] - head * (dy - 0.5 * dx)); ctx.stroke();
    }
    ctx.lineJoin = ctx.lineCap = "round"; marks = [];
    data.poses.forEach(function (pose, k) { if (k !== chosen) { ctx.globalAlpha = pose.moved.length ? 0.4 : 0.13; ctx.strokeStyle = colour("--ink"); ctx.lineWidth = 2; line(pose.line); } });
    data.poses.forEach(function (pose, k) {
      if (!pose.moved.length) return;
      ctx.globalAlpha = k === chosen ? 1 : 0.5; ctx.strokeStyle = colour("--after"); ctx.lineWidth = k === chosen ? 2.6 : 1.4;
      line(pose.line.map(function (v, i) { return v + data.factor * pose.moved[i]; }));
    });
    data.poses.forEach(function (pose, k) {
      var p = pose.at, from = at(p[0], p[1], p[2]), many = pose.errors.length / 3, words = [];
      for (var n = 0; n < many; n++) words.push(data.titles[n] + " " + Math.hypot(pose.errors[3 * n], pose.errors[3 * n + 1], pose.errors[3 * n + 2]).toPrecision(3) + " mm");
      marks.push([from[0], from[1], pose.name + (words.length ? ": " + words.join(", ") : "")]);
      for (var i = 0; i < pose.errors.length; i += 3) {
        ctx.globalAlpha = k === chosen ? 1 : 0.6; ctx.lineWidth = k === chosen ? 2.6 : 1.4;
        ctx.strokeStyle = colour(i / 3 === many - 1 ? "--after" : "--before");
        arrow(from, at(p[0] + data.factor * pose.errors[i], p[1] + data.factor * pose.errors[i + 1], p[2] + data.factor * pose.errors[i + 2]));
      }
    });
    var one = data.poses[chosen];
    ctx.globalAlpha = 1; ctx.strokeStyle = colour("--ink"); ctx.lineWidth = 4.5; line(one.line);
    ctx.fillStyle = colour("--paper"); ctx.lineWidth = 1.6;
    for (var i = 0; i < one.line.length; i += 3) { var c = at(one.line[i], one.line[i + 1], one.line[i + 2]); ctx.beginPath(); ctx.arc(c[0], c[1], 4, 0, 6.3); ctx.fill(); ctx.stroke(); }
    ctx.font = "12px system-ui, sans-serif"; ctx.textAlign = "left";
    data.titles.forEach(function (title, k) {
      ctx.fillStyle = colour(k === data.titles.length - 1 ? "--after" : "--before");
      ctx.fillText("→ " + title, 10, 18 + 16 * k);
    });
    ctx.strokeStyle = ctx.fillStyle = colour("--soft"); ctx.lineWidth = 1;
    [[1, 0, 0, "x"], [0, 1, 0, "y"], [0, 0, 1, "z"]].forEach(function (a) {
      var l = 34, d = a[0] * sa + a[1] * ca, x = 44 + (a[0] * ca - a[1] * sa) * l, y = h - 44 - (a[2] * ch - d * sh) * l;
      ctx.beginPath(); ctx.moveTo(44, h - 44); ctx.lineTo(x, y); ctx.stroke(); ctx.fillText(a[3], x + 3, y);
    });
    name.textContent = one.name;
    canvas.dataset.azimuth = azimuth.toFixed(3);
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
  slider.addEventListener("input", draw);
  window.addEventListener("resize", draw); window.addEventListener("beforeprint", draw); window.addEventListener("afterprint", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
})();
