// Curves over time below the picture. A click on one goes to that time.
(function (s) {
  const run = s.run;
  const mark_colours = { cut: "#b3342d", ruptured: "#d9760a", touched: "#8fb4d8" };

  // Frames with new events since the frame before.
  s.marks = [];
  run.events.forEach(function (event) {
    if (!mark_colours[event.name]) return;
    for (let k = 0; k < run.frames; ++k) {
      const count = event.counts[k] - (k > 0 ? event.counts[k - 1] : 0);
      if (count > 0) s.marks.push({ frame: k, count: count, name: event.name, colour: mark_colours[event.name] });
    }
  });
  s.mark_colours = mark_colours;
  const palette = ["#1b7a5a", "#a33c6e", "#7a6a10", "#2b6cb0", "#c2571a", "#5b3c88", "#444c55", "#b3342d"];
  const graphs = s.graphs = [];
  // Adapts the plots to the present width.
  s.resize_plots = function () { graphs.forEach(function (graph) { graph.resize(); }); };

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

  // Adds the elements of a plot to the page. All are added before the first is drawn, because it takes the width it finds.
  function add_box(plot) {
    const box = document.createElement("div"), head = document.createElement("div"), area = document.createElement("div");
    const cursor = document.createElement("div"), name = document.createElement("b");
    box.className = "plot";
    head.className = "plot-head";
    area.className = "plot-area";
    cursor.className = "plot-cursor";
    head.append(name);
    box.append(head, area, cursor);
    document.getElementById("plots").append(box);
    return { head: head, name: name, area: area, cursor: cursor };
  }

  // The range to show if a few values are far beyond the others, as at the end of a diverging run; else null.
  function clipped_range(series) {
    const sizes = [].concat.apply([], series.map(function (each) { return each.values; }))
      .filter(isFinite).map(Math.abs).sort(function (a, b) { return a - b; });
    const common = sizes[Math.floor(0.8 * sizes.length)];
    if (!(common > 0) || sizes[sizes.length - 1] < 100 * common) return null;
    const negative = series.some(function (each) { return each.values.some(function (value) { return value < 0; }); });
    return [negative ? -3 * common : 0, 3 * common];
  }

  // The unit of a plot; how many digits distinguish its values within the range; the step to which values are rounded.
  function scale_of(plot, range) {
    let low = Infinity, high = -Infinity;
    plot.series.forEach(function (each) {
      each.values.forEach(function (value) {
        if (!isFinite(value) || (range && (value < range[0] || value > range[1]))) return;
        low = Math.min(low, value);
        high = Math.max(high, value);
      });
    });
    const max = Math.max(Math.abs(low), Math.abs(high)), span = high - low;
    const unit = s.unit_for(plot.unit, isFinite(max) ? max : 0);
    const digits = span > 0 && isFinite(span) ? Math.min(11, Math.max(0, Math.ceil(Math.log10(max / span))) + 2) : 4;
    const step = max > 0 && isFinite(max) ? Math.pow(10, Math.floor(Math.log10(max / unit[0])) + 1 - Math.max(5, digits + 1)) : 0;
    // `floor`: values below it are rounding of a sum of the others.
    return { size: unit[0], name: unit[1], digits: digits, step: step, floor: isFinite(max) ? 2e-15 * max / unit[0] : 0 };
  }

  // The values of a frame beside the title, each as wide as its longest text, so that nothing moves during playback.
  function add_values(series, scale, head) {
    const stride = Math.max(1, Math.floor(run.frames / 300));
    function text(each, frame) {
      const value = each.values[frame] / scale.size, rounded = s.round_to(value, scale.step);
      if (Math.abs(value) <= scale.floor) return each.label + " 0";
      return each.label + " " + (rounded === 0 ? s.number(value, 2) : s.number(rounded, 12));  // a value much smaller than the others is not 0
    }
    const parts = series.map(function (each) {
      const part = document.createElement("span");
      let max = 0;
      for (let k = 0; k < run.frames; k += stride) max = Math.max(max, text(each, k).length);
      part.style.color = each.colour;
      part.style.minWidth = 0.92 * max + "ch";
      head.append(part);
      return part;
    });
    return function (frame) { parts.forEach(function (part, k) { part.textContent = text(series[k], frame); }); };
  }

  function add_remark(head, text) {
    const remark = document.createElement("small");
    remark.textContent = remark.title = text;
    head.append(remark);
  }

  // Draws a plot, and returns a function that shows the time and the values of a frame.
  function draw_plot(plot, box, player) {
    const area = box.area, cursor = box.cursor, series = plot.series, range = clipped_range(series), scale = scale_of(plot, range);
    const rows = run.times.map(function (time, k) {
      return [time].concat(series.map(function (each) { return isFinite(each.values[k]) ? each.values[k] / scale.size : null; }));
    });
    box.name.textContent = plot.title + (scale.name ? ", " + scale.name : "") + (range ? " (peaks cut off)" : "");
    const show_values = add_values(series, scale, box.head);
    if (plot.leaves_out && plot.leaves_out.length > 0) add_remark(box.head, "the sum leaves out " + plot.leaves_out.join(", "));
    const graph = new Dygraph(area, rows, {
      labels: ["t"].concat(series.map(function (each) { return each.label; })),
      colors: series.map(function (each) { return each.colour; }),
      legend: "never", strokeWidth: 1.6, axisLabelFontSize: 11, gridLineColor: "#e6eaee", axisLineColor: "#aab3bd",
      axisLabelWidth: 52, highlightCircleSize: 0, digitsAfterDecimal: 4, underlayCallback: draw_marks, rightGap: 8,
      labelsKMB: false, valueRange: range && range.map(function (each) { return each / scale.size; }), sigFigs: 4, xRangePad: 1,
      axes: { x: { axisLabelFormatter: function (value) { return s.number(value) + " s"; } },
              y: { axisLabelFormatter: function (value) { return s.number(value, scale.digits + 1); }, pixelsPerLabel: 14 } },
      clickCallback: function (event, time) { player.pause(); player.go_to_time(nearest(time)); },
      drawCallback: function () { if (s.show_cursors) s.show_cursors(player.frame); }
    });
    graphs.push(graph);
    return function (frame) {
      const place = graph.getArea(), x = graph.toDomXCoord(run.times[frame]);
      cursor.hidden = x < place.x || x > place.x + place.w;
      cursor.style.left = x + "px";
      cursor.style.top = area.offsetTop + place.y + "px";
      cursor.style.height = place.h + "px";
      show_values(frame);
    };
  }

  function nearest(time) {
    const lower = run.frame_at(time), upper = Math.min(run.frames - 1, lower + 1);
    return Math.abs(run.times[upper] - time) < Math.abs(time - run.times[lower]) ? run.times[upper] : run.times[lower];
  }

  // Sweeps per step. Records within one step of the integrator keep the value before.
  function sweeps_per_step() {
    let value = NaN;
    return run.sweeps.map(function (sweeps, k) {
      const steps = k > 0 ? run.steps[k] - run.steps[k - 1] : 0;
      if (steps > 0) value = (sweeps - run.sweeps[k - 1]) / steps;
      return value;
    });
  }

  // One plot for several elements. What all labels share is in the title alone.
  function plot_of(curves, unit) {
    function shared(part) { return curves.every(function (each) { return each[part] === curves[0][part]; }); }
    const single = curves.length === 1, name = shared("name"), kind = shared("kind");
    const labels = curves.map(function (each) {
      return [name ? "" : each.name, kind ? "" : each.kind].filter(Boolean).join(", ");
    });
    const unambiguous = new Set(labels).size === labels.length;
    const title = [name ? curves[0].name : "", kind ? curves[0].kind : ""].filter(Boolean).join(", ") || "elements";
    const series = curves.map(function (each, k) {
      const label = single ? "now" : unambiguous ? labels[k] : (labels[k] + " " + each.element).trim();
      return { label: label, colour: palette[k % palette.length], values: each.values };
    });
    return { title: title + (single || unambiguous || title === "elements" ? "" : ", elements"), unit: unit, series: series };
  }

  s.make_plots = function (player) {
    if (run.frames < 2) return;
    const total = run.kinetic.map(function (value, k) { return value + run.potential[k]; });
    const plots = [
      { title: "energy", unit: "J",
        series: [{ label: "kinetic", colour: "#c2571a", values: run.kinetic },
                 { label: "potential", colour: "#1f5f99", values: run.potential },
                 { label: "sum", colour: "#444c55", values: total }],
        leaves_out: run.about.energy_leaves_out },
      { title: run.internal_steps ? "evaluations per internal step" : "sweeps per time step", unit: "",
        series: [{ label: "now", colour: "#5b3c88", values: sweeps_per_step() }] }];
    const units = new Map();
    run.curves.forEach(function (curve) { units.set(curve.unit, (units.get(curve.unit) || []).concat(curve)); });
    units.forEach(function (curves, unit) { plots.push(plot_of(curves, unit)); });
    const boxes = plots.map(add_box);
    const cursors = plots.map(function (plot, k) { return draw_plot(plot, boxes[k], player); });
    s.show_cursors = function (frame) { cursors.forEach(function (show) { show(frame); }); };
    s.show_cursors(0);
    s.resize_plots();
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
