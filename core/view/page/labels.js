// Labels on the picture: time, legend of the colours, scale, directions of the axes.
(function (s) {
  const run = s.run;
  function element(id) { return document.getElementById(id); }

  function show_arrow_scale() {
    const mode = s.shown.arrows, max = s.arrow_modes.max_force[mode], part = element("legend-arrow");
    const what = mode === "resultants" && s.arrow_modes.differ ? ", a load’s resultant" : "", lines = [];
    if (s.shown.forces && s.arrow_modes.max_force.nodes > 0)
      lines.push(max > 0 ? "longest arrow " + s.force_text(max) + what : "the loads have no resultant: show forces at each node");
    // Of what was observed.
    if (run.is_learned && (s.shown.observed || s.shown.held_out)) {
      const velocity = run.observed_kinds.largest("velocity"), force = run.observed_kinds.largest("force");
      if (s.shown.velocities && velocity > 0) lines.push("longest observed velocity " + s.number(velocity, 3) + " m/s");
      if (s.shown.reactions && force > 0) lines.push("longest observed force " + s.force_text(force));
    }
    part.hidden = lines.length === 0;
    part.textContent = lines.join("; ");
  }

  function show_touch_scale() {
    const part = element("legend-touch"), usual = s.force_text(s.touches.longest_force), most = s.force_text(s.touches.max_force);
    part.hidden = !s.shown.touches || s.touches.most === 0;
    part.textContent = part.hidden ? "" : "longest arrow between bodies " + usual + (most === usual ? "" : "; beyond: up to " + most);
  }

  function draw_bar(table) {
    const bar = element("legend-bar"), context = bar.getContext("2d");
    for (let x = 0; x < bar.width; ++x) {
      const at = 3 * Math.round(255 * x / (bar.width - 1));
      context.fillStyle = "rgb(" + table.slice(at, at + 3).join(",") + ")";
      context.fillRect(x, 0, 1, bar.height);
    }
  }

  // Of values that were learned.
  function show_painted(shown) {
    const paint = shown.paint;
    element("legend-title").textContent = shown.title + (shown.unit ? ", " + shown.unit : "");
    element("legend-bar").hidden = paint.ticks.length === 0;
    draw_bar(paint.table);
    if (paint.ticks.length === 1) element("legend-ticks").append(document.createElement("span"));  // in the middle
    // As many digits as tell the ends apart.
    const low = paint.ticks[0], high = paint.ticks[paint.ticks.length - 1];
    const digits = high > low ? Math.min(9, Math.max(3, 2 + Math.ceil(Math.log10(Math.max(Math.abs(low), Math.abs(high)) / (high - low))))) : 4;
    paint.ticks.forEach(function (value) {
      const tick = document.createElement("span");
      tick.textContent = s.number(value, digits);
      element("legend-ticks").append(tick);
    });
    if (paint.ticks.length === 1) element("legend-ticks").append(document.createElement("span"));
    const notes = [];
    if (paint.ticks.length === 0) notes.push("the result has none");
    if (paint.open > 0) notes.push("grey" + (paint.of === "springs" ? ", dashed" : "") + ": " + paint.open + " of " + paint.count + " not determined by the data");
    if (paint.of !== "springs" || paint.without > 0) notes.push("pale: without such a value");
    element("legend-note").textContent = notes.join("; ");
  }

  function show_legend() {
    const quantity = s.shown.colour;
    element("legend").hidden = false;
    element("legend-bar").hidden = quantity === "contact";
    element("legend-ticks").textContent = "";
    element("legend-note").textContent = "";
    show_arrow_scale();
    show_touch_scale();
    if (quantity === "contact") {
      element("legend-title").textContent = "orange: in contact";
      return;
    }
    const tension = quantity === "tension", shown = run.quantity(quantity), range = shown.range, unit = shown.unit;
    if (shown.paint) {
      show_painted(shown);
      return;
    }
    const table = shown.symmetric ? s.colours.tension.table : s.colours.speed.table;
    element("legend-title").textContent = shown.title + (range.shown > 0 ? (unit ? ", " : "") : ": 0 ") + unit;
    element("legend-bar").hidden = range.shown === 0;
    if (range.shown === 0) return;
    draw_bar(table);
    const ticks = shown.symmetric ? [-range.shown, 0, range.shown] : [0, range.shown / 2, range.shown];
    ticks.forEach(function (value) {
      const tick = document.createElement("span");
      tick.textContent = (shown.symmetric && value > 0 ? "+" : "") + s.number(value);
      element("legend-ticks").append(tick);
    });
    let note = tension ? "blue: compression, grey: slack, red: tension" : shown.of_state !== undefined ? "pale: springs without it" : "";
    if (range.max > range.shown) note += (note ? "; " : "") + "beyond: up to " + s.number(range.max, 3) + " " + unit;
    element("legend-note").textContent = note;
  }

  function show_scale(cell) {
    const camera = s.camera.camera, view = element("view");
    const distance = camera.position.distanceTo(s.camera.target);
    const pixel = 2 * distance * Math.tan(camera.fov * Math.PI / 360) / Math.max(1, view.clientHeight);
    const length = s.round_down(150 * pixel);
    element("scale-bar").style.width = length / pixel + "px";
    element("scale-text").textContent = s.length_text(length) + (cell ? "; grid of the plane: " + s.length_text(cell) : "");
  }

  function show_axes() {
    const canvas = element("axes"), context = canvas.getContext("2d"), middle = canvas.width / 2;
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.font = "26px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.lineWidth = 4;
    const toward = s.camera.camera.matrixWorldInverse;
    const arms = ["x", "y", "z"].map(function (name, k) {
      const arm = new THREE.Vector3().setComponent(k, 1).transformDirection(toward);
      return { name: name, arm: arm, colour: ["#b3342d", "#2f7d3b", "#2a5caa"][k] };
    }).sort(function (a, b) { return a.arm.z - b.arm.z; });
    arms.forEach(function (each) {
      const x = middle + 58 * each.arm.x, y = middle - 58 * each.arm.y;
      context.strokeStyle = context.fillStyle = each.colour;
      context.beginPath();
      context.moveTo(middle, middle);
      context.lineTo(x, y);
      context.stroke();
      if (Math.hypot(each.arm.x, each.arm.y) > 0.15) context.fillText(each.name, middle + 76 * each.arm.x, middle - 76 * each.arm.y);
    });
  }

  // As many decimals as distinguish one record from the next.
  const last = run.times[run.frames - 1];
  const gap = run.frames > 1 ? (last - run.times[0]) / (run.frames - 1) : 1;
  const decimals = Math.min(9, Math.max(0, Math.ceil(-Math.log10(gap || 1) + 0.3)));
  s.labels = {
    legend: show_legend,
    exaggeration: function () {
      const note = element("exaggerated");
      note.hidden = s.exaggeration === 1;
      document.body.classList.toggle("exaggerated", !note.hidden);  // shown even if other labels are hidden
      note.textContent = "displacement × " + s.number(s.exaggeration) + (run.about.surfaces.length > 0 ? ", obstacles × 1" : "");
    },
    camera: function (cell) { show_scale(cell); show_axes(); },
    clock: function (frame) {
      element("clock-time").textContent = "t = " + run.times[frame].toFixed(decimals) + " s";
      element("time").textContent = run.times[frame].toFixed(decimals) + " of " + last.toFixed(decimals) + " s";
    }
  };
})(springnet);
