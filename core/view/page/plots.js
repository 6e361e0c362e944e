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
  const palette = ["#1b7a5a", "#a33c6e", "#7a6a10", "#2b6cb0", "#c2571a", "#5b3c88", "#444c55", "#b3342d"];
  const graphs = s.graphs = [];
  // To the width that there is now.
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

  // The place of a plot. All are there before the first is drawn, which takes the width it finds.
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

  // The usual range of the values where single ones, as at the end of a run that diverges, are far beyond; else null.
  function usual_range(series) {
    const sizes = [].concat.apply([], series.map(function (each) { return each.values; }))
      .filter(isFinite).map(Math.abs).sort(function (a, b) { return a - b; });
    const common = sizes[Math.floor(0.8 * sizes.length)];
    if (!(common > 0) || sizes[sizes.length - 1] < 100 * common) return null;
    const negative = series.some(function (each) { return each.values.some(function (value) { return value < 0; }); });
    return [negative ? -3 * common : 0, 3 * common];
  }

  // The unit of a plot, how many digits tell its values from each other, from those within the range, and to what a single
  // one is rounded.
  function scale_of(plot, range) {
    let low = Infinity, high = -Infinity;
    plot.series.forEach(function (each) {
      each.values.forEach(function (value) {
        if (!isFinite(value) || (range && (value < range[0] || value > range[1]))) return;
        low = Math.min(low, value);
        high = Math.max(high, value);
      });
    });
    const most = Math.max(Math.abs(low), Math.abs(high)), span = high - low;
    const unit = s.unit_for(plot.unit, isFinite(most) ? most : 0);
    const digits = span > 0 && isFinite(span) ? Math.min(11, Math.max(0, Math.ceil(Math.log10(most / span))) + 2) : 4;
    const step = most > 0 && isFinite(most) ? Math.pow(10, Math.floor(Math.log10(most / unit[0])) + 1 - Math.max(5, digits + 1)) : 0;
    // What is this small beside the others is rounding of their sum.
    return { size: unit[0], name: unit[1], digits: digits, step: step, floor: isFinite(most) ? 2e-15 * most / unit[0] : 0 };
  }

  // The values of a frame beside the title, each as wide as it is at most: the words stay where they are.
  function add_values(series, scale, head) {
    const stride = Math.max(1, Math.floor(run.frames / 300));
    function text(each, frame) {
      const value = each.values[frame] / scale.size, known = s.known(value, scale.step);
      if (Math.abs(value) <= scale.floor) return each.label + " 0";
      return each.label + " " + (known === 0 ? s.number(value, 2) : s.number(known, 12));  // what is small beside others is not 0
    }
    const parts = series.map(function (each) {
      const part = document.createElement("span");
      let most = 0;
      for (let k = 0; k < run.frames; k += stride) most = Math.max(most, text(each, k).length);
      part.style.color = each.colour;
      part.style.minWidth = 0.92 * most + "ch";
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

  // Draws it; returns what shows the time and the values of a frame.
  function draw_plot(plot, box, player) {
    const area = box.area, cursor = box.cursor, series = plot.series, range = usual_range(series), scale = scale_of(plot, range);
    const rows = run.times.map(function (time, k) {
      return [time].concat(series.map(function (each) { return isFinite(each.values[k]) ? each.values[k] / scale.size : null; }));
    });
    box.name.textContent = plot.title + (scale.name ? ", " + scale.name : "") + (range ? " (peaks cut off)" : "");
    const show_values = add_values(series, scale, box.head);
    if (plot.leaves_out && plot.leaves_out.length > 0) add_remark(box.head, "sum leaves out " + plot.leaves_out.join(", "));
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

  // Records that lie within one step of the integrator have the value of those before.
  function per_step() {
    let value = NaN;
    return run.sweeps.map(function (sweeps, k) {
      const steps = k > 0 ? run.steps[k] - run.steps[k - 1] : 0;
      if (steps > 0) value = (sweeps - run.sweeps[k - 1]) / steps;
      return value;
    });
  }

  // Curves of elements in one plot: what their labels share stands in the title alone.
  function plot_of(curves, unit) {
    function shared(part) { return curves.every(function (each) { return each[part] === curves[0][part]; }); }
    const one = curves.length === 1, name = shared("name"), kind = shared("kind");
    const labels = curves.map(function (each) {
      return [name ? "" : each.name, kind ? "" : each.kind].filter(Boolean).join(", ");
    });
    const clear = new Set(labels).size === labels.length;
    const title = [name ? curves[0].name : "", kind ? curves[0].kind : ""].filter(Boolean).join(", ") || "elements";
    const series = curves.map(function (each, k) {
      const label = one ? "now" : clear ? labels[k] : (labels[k] + " " + each.element).trim();
      return { label: label, colour: palette[k % palette.length], values: each.values };
    });
    return { title: title + (one || clear || title === "elements" ? "" : ", elements"), unit: unit, series: series };
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
      { title: run.own_steps ? "evaluations an internal step" : "sweeps a time step", unit: "",
        series: [{ label: "now", colour: "#5b3c88", values: per_step() }] }];
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
