// Of a net that was learned: its values as colours, the motion with the values at the start, and places observed.
(function (s) {
  const run = s.run, about = run.about.learned;
  run.learned = [];
  run.elements = 0;  // drawn as dots at their middle
  run.is_learned = about !== null;
  if (!about) return;
  s.shown.start = s.shown.observed = s.shown.learned = true;
  s.shown.faces = false;  // they would dim the colours behind them

  const element_first = run.block("learned_element_first", Uint32Array), element_nodes = run.block("learned_element_nodes", Uint32Array);
  run.element_numbers = run.block("learned_elements", Uint32Array);
  run.elements = run.element_numbers.length;
  // Into `out` at 3 k: the mean of the element's nodes.
  run.middle_of = function (k, positions, out, at) {
    const count = element_first[k + 1] - element_first[k];
    out[at] = out[at + 1] = out[at + 2] = 0;
    for (let j = element_first[k]; j < element_first[k + 1]; ++j) {
      for (let c = 0; c < 3; ++c) out[at + c] += positions[3 * element_nodes[j] + c] / count;
    }
  };

  const counts = { springs: run.springs, nodes: run.nodes, elements: run.elements };
  run.learned = about.map(function (each, which) {
    const places = run.block("learned" + which + "_places", Uint32Array), numbers = run.block("learned" + which + "_numbers", Float32Array);
    const row_of = new Int32Array(counts[each.of]).fill(-1);
    places.forEach(function (place, row) { row_of[place] = row; });
    return Object.assign({ count: places.length, row_of: row_of,
      // Of a place; null if it has no such value. Without an interval its ends are nan.
      at: function (place) {
        const row = 5 * row_of[place];
        return row < 0 ? null : { start: numbers[row], value: numbers[row + 1], lower: numbers[row + 2], upper: numbers[row + 3],
                                  determined: numbers[row + 4] };
      } }, each);
  });
  // The data say nothing of it. A search that finds no intervals at all does not know.
  s.is_open = function (found) { return !isFinite(found.upper) && isFinite(found.determined); };

  // What colours tell of a value; null: nothing.
  const kinds = {
    value: { label: "learned", of: function (found) { return found.value; } },
    ratio: { label: "ratio to the start", unit: "", of: function (found) {
      const ratio = found.value / found.start;
      return ratio > 0 && isFinite(ratio) ? ratio : null;
    } },
    width: { label: "half width of the interval", unit: "% of the value", of: function (found) {
      const width = 50 * (found.upper - found.lower) / Math.abs(found.value);
      return isFinite(width) ? width : null;
    } },
    determined: { label: "determined by the data", unit: "% of the value", of: function (found) {
      return isFinite(found.determined) ? 100 * found.determined : null;
    } }
  };
  s.paint_kinds = kinds;

  // Shares of the colour table for values, and values to write below it.
  function scale_of(kind, values) {
    let low = Infinity, high = -Infinity;
    values.forEach(function (value) { low = Math.min(low, value); high = Math.max(high, value); });
    if (kind === "determined") { low = 0; high = 100; }
    if (kind === "ratio") {
      const reach = Math.max(Math.log(high), -Math.log(low), 0.01);
      low = Math.exp(-reach);
      high = Math.exp(reach);
    } else if (kind === "width" && !(high > 30 * low)) {
      low = 0;
    }
    const logarithmic = kind === "ratio" || (kind !== "determined" && low > 0 && high > 30 * low);
    const map = logarithmic ? Math.log : Number, a = map(low), b = map(high);
    const middle = logarithmic ? Math.exp((a + b) / 2) : (a + b) / 2;
    return { share: function (value) { return b > a ? (map(value) - a) / (b - a) : 0.5; },
             ticks: high > low ? [low, middle, high] : values.length > 0 ? [low] : [] };
  }

  const made = new Map();
  // name: "learned", the number of the values, ".", a kind.
  s.paint = function (name) {
    if (made.has(name)) return made.get(name);
    const parts = name.slice(7).split("."), learned = run.learned[Number(parts[0])], kind = parts[1], shows = kinds[kind];
    const known = [];
    let open = 0, without = 0;
    for (let place = 0; place < counts[learned.of]; ++place) {
      const found = learned.at(place);
      if (!found) { ++without; continue; }
      if (s.is_open(found)) ++open;
      if (s.is_open(found) && kind !== "determined") continue;
      const value = shows.of(found);
      if (value !== null) known.push(value);
    }
    const scale = scale_of(kind, known), table = kind === "ratio" ? s.colours.ratio : s.colours.learned;
    const paint = {
      of: learned.of, table: table, ticks: scale.ticks, open: open, without: without, count: learned.count,
      title: learned.name + ", " + shows.label, unit: shows.unit === undefined ? learned.unit : shows.unit,
      // Offset in the table; -1 without such a value, -2 if the data do not determine it, -3 if this is not known.
      look: function (place) {
        const found = learned.at(place);
        if (!found) return -1;
        if (s.is_open(found) && kind !== "determined") return -2;
        const value = shows.of(found);
        return value === null ? -3 : s.colours.offset(scale.share(value), 1, false);
      }
    };
    made.set(name, paint);
    return paint;
  };
  s.shown.colour = run.learned.length > 0 ? "learned0.value" : s.shown.colour;

  // Lines about the values of a spring, node or element.
  s.learned_numbers = function (of, place) {
    const rows = [];
    run.learned.forEach(function (learned) {
      const found = learned.of === of ? learned.at(place) : null, unit = learned.unit ? " " + learned.unit : "";
      if (!found) return;
      const open = s.is_open(found);
      rows.push([learned.name, s.number(found.value, 5) + unit],
                ["95 % interval", isFinite(found.upper) ? s.number(found.lower, 4) + " to " + s.number(found.upper, 4) + unit :
                 open ? "none: not determined" : "not known"],
                ["at the start", s.number(found.start, 5) + unit]);
      if (isFinite(found.determined)) rows.push(["determined", s.number(100 * found.determined, 3) + " %"]);
    });
    return rows;
  };

  run.start_positions = run.rows("start_positions", 3 * run.nodes);
  const first = run.block("observed_first", Uint32Array), nodes = run.block("observed_nodes", Uint32Array);
  const points = run.block("observed_points", Float32Array);
  run.observed_most = 0;
  for (let frame = 0; frame < run.frames; ++frame) run.observed_most = Math.max(run.observed_most, first[frame + 1] - first[frame]);
  // Places x, y, z and nodes; a node is run.never for a point of the surface.
  run.observed = function (frame) {
    return { nodes: nodes.subarray(first[frame], first[frame + 1]), points: points.subarray(3 * first[frame], 3 * first[frame + 1]) };
  };
  run.observed_frames = run.times.reduce(function (sum, _, frame) { return sum + (first[frame + 1] > first[frame] ? 1 : 0); }, 0);

  // The layers of the picture that show them.
  s.LearnedLayers = function (spring_width, dot_size) {
    const colours = s.colours;
    const open = new s.Segments(run.springs, { width: spring_width, dash: 4 });
    const start = new s.Segments(run.springs, { width: Math.max(1, 0.5 * spring_width), opacity: 0.6 });
    const start_dots = new s.Dots(run.springs > 0 ? 0 : run.nodes), observed = new s.Dots(run.observed_most, 0.6), middles = new s.Dots(run.elements);
    this.layers = [open, start, start_dots, observed, middles];
    this.open = open;
    this.middles = middles;
    function tint(dots, k, table, offset, size) {
      for (let c = 0; c < 3; ++c) dots.tints[3 * k + c] = table[offset + c];
      dots.sizes[k] = size;
    }
    // Colour and offset of a dot with this look.
    this.dot = function (paint, look) {
      return look >= 0 ? [paint.table, look] : [look === -1 ? colours.without : colours.open, 0];
    };
    this.show = function (frame, positions) {
      start.begin();
      start_dots.mesh.visible = s.shown.start && run.springs === 0;
      if (s.shown.start) {
        const before = s.drawn_start(frame);
        for (let k = 0; k < run.springs; ++k) start.add(before, run.ends[2 * k], run.ends[2 * k + 1], colours.start, 0);
        if (run.springs === 0) {
          start_dots.positions.set(before);
          for (let k = 0; k < run.nodes; ++k) tint(start_dots, k, colours.start, 0, dot_size);
          start_dots.update();
        }
      }
      start.end();

      const seen = s.drawn_observed(frame);
      observed.mesh.visible = s.shown.observed && seen.length > 0;
      if (observed.mesh.visible) {
        observed.positions.set(seen);
        for (let k = 0; 3 * k < seen.length; ++k) tint(observed, k, colours.observed, 0, dot_size + 7);
        observed.mesh.geometry.setDrawRange(0, seen.length / 3);
        observed.update();
      }

      const quantity = run.quantity(s.shown.colour), paint = quantity.paint;
      middles.mesh.visible = s.shown.learned && Boolean(paint) && paint.of === "elements";
      if (!middles.mesh.visible) return;
      for (let k = 0; k < run.elements; ++k) {
        const look = this.dot(paint, paint.look(k));
        run.middle_of(k, positions, middles.positions, 3 * k);
        tint(middles, k, look[0], look[1], 1.6 * dot_size);
      }
      middles.update();
    };
  };
})(springnet);
