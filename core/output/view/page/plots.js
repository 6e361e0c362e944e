// Curves over time below the picture. A click on one goes to that time.
(function (s) {
  const run = s.run;
  const marked = { cut: "#b3342d", ruptured: "#d9760a", touched: "#8fb4d8" };

  // Frames in which something happened that had not in the frame before.
  s.marks = [];
  run.events.forEach(function (event) {
    if (!marked[event.name]) return;
    for (let k = 0; k < run.frames; ++k) {
      const count = event.counts[k] - (k > 0 ? event.counts[k - 1] : 0);
      if (count > 0) s.marks.push({ frame: k, count: count, name: event.name, colour: marked[event.name] });
    }
  });
  s.mark_colours = marked;

  function draw_marks(context, area, graph) {
    s.marks.forEach(function (mark) {
      const x = graph.toDomXCoord(run.times[mark.frame]);
      if (x < area.x || x > area.x + area.w) return;
      context.strokeStyle = mark.colour;
      context.globalAlpha = mark.name === "touched" ? 0.35 : 0.6;
      context.beginPath();
      context.moveTo(x, area.y);
      context.lineTo(x, area.y + area.h);
      context.stroke();
      context.globalAlpha = 1;
    });
  }

  // The place of a plot. All are there before the first is drawn, which takes the width it finds.
  function add_box(plot) {
    const box = document.createElement("div"), head = document.createElement("div"), area = document.createElement("div");
    const cursor = document.createElement("div"), name = document.createElement("b"), values = document.createElement("span");
    box.className = "plot";
    head.className = "plot-head";
    area.className = "plot-area";
    cursor.className = "plot-cursor";
    name.textContent = plot.title;
    head.append(name, values);
    box.append(head, area, cursor);
    document.getElementById("plots").append(box);
    return { head: head, name: name, area: area, cursor: cursor, values: values };
  }

  // The usual range of the values where single ones, as at the end of a run that diverges, are far beyond; else null.
  function usual_range(series) {
    const sizes = [].concat.apply([], series.map(function (each) { return each.values; }))
      .filter(isFinite).map(Math.abs).sort(function (a, b) { return a - b; });
    const common = sizes[Math.floor(0.8 * sizes.length)];
    if (!(common > 0) || sizes[sizes.length - 1] < 100 * common) return null;
    const negative = series.some(function (each) { return each.values.some(function (value) { return value < 0; }); });
    return [negative ? -3 * common : 0, 3 * common];
  }

  // Draws it; returns what shows the time and the values of a frame.
  function draw_plot(series, box, player) {
    const area = box.area, cursor = box.cursor, values = box.values;
    const rows = run.times.map(function (time, k) {
      return [time].concat(series.map(function (each) { return isFinite(each.values[k]) ? each.values[k] : null; }));
    });
    const range = usual_range(series);
    if (range) box.name.textContent += " (peaks cut off)";
    const graph = new Dygraph(area, rows, {
      labels: ["t"].concat(series.map(function (each) { return each.label; })),
      colors: series.map(function (each) { return each.colour; }),
      legend: "never", strokeWidth: 1.6, axisLabelFontSize: 11, gridLineColor: "#e6eaee", axisLineColor: "#aab3bd",
      axisLabelWidth: 52, highlightCircleSize: 0, digitsAfterDecimal: 4, underlayCallback: draw_marks, rightGap: 8,
      labelsKMB: false, valueRange: range, sigFigs: 4, xRangePad: 1,
      axes: { x: { axisLabelFormatter: function (value) { return s.number(value) + " s"; } },
              y: { axisLabelFormatter: function (value) { return s.number(value, 3); } } },
      clickCallback: function (event, time) { player.pause(); player.go_to_time(nearest(time)); },
      drawCallback: function () { if (s.show_cursors) s.show_cursors(player.frame); }
    });
    return function (frame) {
      const place = graph.getArea(), x = graph.toDomXCoord(run.times[frame]);
      cursor.hidden = x < place.x || x > place.x + place.w;
      cursor.style.left = x + "px";
      cursor.style.top = box.head.offsetHeight + place.y + "px";
      cursor.style.height = place.h + "px";
      values.textContent = "";
      series.forEach(function (each) {
        const part = document.createElement("span");
        part.style.color = each.colour;
        part.textContent = (each.label ? each.label + " " : "") + s.number(each.values[frame], 3) + "  ";
        values.append(part);
      });
    };
  }

  function nearest(time) {
    const lower = run.frame_at(time), upper = Math.min(run.frames - 1, lower + 1);
    return Math.abs(run.times[upper] - time) < Math.abs(time - run.times[lower]) ? run.times[upper] : run.times[lower];
  }

  function per_step() {
    return run.sweeps.map(function (sweeps, k) {
      const steps = k > 0 ? run.steps[k] - run.steps[k - 1] : 0;
      return steps > 0 ? (sweeps - run.sweeps[k - 1]) / steps : NaN;
    });
  }

  s.make_plots = function (player) {
    if (run.frames < 2) return;
    const total = run.kinetic.map(function (value, k) { return value + run.potential[k]; });
    const plots = [
      { title: "energy, J", series: [{ label: "kinetic", colour: "#c2571a", values: run.kinetic },
                             { label: "potential", colour: "#1f5f99", values: run.potential },
                             { label: "total", colour: "#444c55", values: total }] },
      { title: "sweeps a time step", series: [{ label: "sweeps", colour: "#5b3c88", values: per_step() }] }];
    const units = new Map();
    run.curves.forEach(function (curve) { units.set(curve.unit, (units.get(curve.unit) || []).concat(curve)); });
    const palette = ["#1b7a5a", "#a33c6e", "#7a6a10", "#2b6cb0", "#c2571a", "#5b3c88", "#444c55", "#b3342d"];
    units.forEach(function (curves, unit) {
      const title = curves.length === 1 ? curves[0].label : curves.every(function (c) { return c.unit === "m^3"; }) ? "volumes" : "elements";
      const series = curves.map(function (curve, k) {
        return { label: curves.length === 1 ? "now" : curve.label, colour: palette[k % palette.length], values: curve.values };
      });
      plots.push({ title: title + ", " + unit.replace("^2", "²").replace("^3", "³"), series: series });
    });
    const boxes = plots.map(add_box);
    const cursors = plots.map(function (plot, k) { return draw_plot(plot.series, boxes[k], player); });
    s.show_cursors = function (frame) { cursors.forEach(function (show) { show(frame); }); };
  };

  s.show_marks = function () {
    const canvas = document.getElementById("marks"), context = canvas.getContext("2d");
    canvas.width = canvas.clientWidth;
    const span = Math.max(1, run.frames - 1), half = 8;  // half the width of the bar's handle
    s.marks.forEach(function (mark) {
      context.fillStyle = mark.colour;
      const x = half + mark.frame / span * (canvas.width - 2 * half);
      const height = mark.name === "touched" ? 5 : 10;
      context.fillRect(x - 1, 10 - height, 2, height);
    });
  };
})(springnet);
