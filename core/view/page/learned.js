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
    } },
    from_guess: { label: "from the guess", unit: "% of the value", of: function (found) {
      return isFinite(found.from_guess) ? 100 * found.from_guess : null;
    } }
  };
  // Shares are told of values without an interval, too.
  function is_share(kind) { return kind === "determined" || kind === "from_guess"; }
  s.paint_kinds = kinds;

  const counts = { springs: run.springs, nodes: run.nodes, elements: run.elements };
  run.learned = about.map(function (each, which) {
    const places = run.block("learned" + which + "_places", Uint32Array), numbers = run.block("learned" + which + "_numbers", Float32Array);
    const row_of = new Int32Array(counts[each.of]).fill(-1);
    places.forEach(function (place, row) { row_of[place] = row; });
    // Without a guess that has weight, its share is what the data do not determine, which is no news.
    let guessed = false;
    for (let row = 0; row < numbers.length; row += 6) guessed = guessed || numbers[row + 5] > 1 - numbers[row + 4] + 1e-4;
    return Object.assign({ count: places.length, row_of: row_of,
      kinds: Object.keys(kinds).filter(function (kind) { return kind !== "from_guess" || guessed; }),
      // Of a place; null if it has no such value. Without an interval its ends are nan.
      at: function (place) {
        const row = 6 * row_of[place];
        return row < 0 ? null : { start: numbers[row], value: numbers[row + 1], lower: numbers[row + 2], upper: numbers[row + 3],
                                  determined: numbers[row + 4], from_guess: numbers[row + 5] };
      } }, each);
  });
  // The data say nothing of it. A search that finds no intervals at all does not know.
  s.is_open = function (found) { return !isFinite(found.upper) && isFinite(found.determined); };

  // Shares of the colour table for values, and values to write below it.
  function scale_of(kind, values) {
    let low = Infinity, high = -Infinity;
    values.forEach(function (value) { low = Math.min(low, value); high = Math.max(high, value); });
    if (is_share(kind)) { low = 0; high = 100; }
    if (kind === "ratio") {
      const reach = Math.max(Math.log(high), -Math.log(low), 0.01);
      low = Math.exp(-reach);
      high = Math.exp(reach);
    } else if (kind === "width" && !(high > 30 * low)) {
      low = 0;
    }
    const logarithmic = kind === "ratio" || (!is_share(kind) && low > 0 && high > 30 * low);
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
      if (s.is_open(found) && !is_share(kind)) ++open;
      if (s.is_open(found) && !is_share(kind)) continue;
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
        if (s.is_open(found) && !is_share(kind)) return -2;
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
      if (learned.kinds.includes("from_guess")) rows.push(["from the guess", s.number(100 * found.from_guess, 3) + " %"]);
    });
    return rows;
  };

  run.start_positions = run.rows("start_positions", 3 * run.nodes);
  const first = run.block("observed_first", Uint32Array), nodes = run.block("observed_nodes", Uint32Array);
  const points = run.block("observed_points", Float32Array), sorts = run.block("observed_kinds", Uint8Array);
  run.observed_most = 0;
  for (let frame = 0; frame < run.frames; ++frame) run.observed_most = Math.max(run.observed_most, first[frame + 1] - first[frame]);
  // Places, velocities or forces, x, y, z, and nodes; a node is run.never for a point of the surface. kinds: 0 position,
  // 1 velocity, 2 force, and 4 more of one held out.
  run.observed = function (frame) {
    return { nodes: nodes.subarray(first[frame], first[frame + 1]), points: points.subarray(3 * first[frame], 3 * first[frame + 1]),
             kinds: sorts.subarray(first[frame], first[frame + 1]) };
  };
  const vector_kinds = { velocity: 1, force: 2 };
  // How many a record has at most, and how long the longest of all is. Of many arrows some are drawn.
  const most_arrows = 200, most = new Uint32Array(8), longest = new Float32Array(8);
  for (let frame = 0; frame < run.frames; ++frame) {
    const here = new Uint32Array(8), seen = run.observed(frame);
    seen.kinds.forEach(function (kind, k) {
      most[kind] = Math.max(most[kind], ++here[kind]);
      longest[kind] = Math.max(longest[kind], Math.hypot(seen.points[3 * k], seen.points[3 * k + 1], seen.points[3 * k + 2]));
    });
  }
  function pitch(kind) { return Math.ceil(Math.max(most[kind], most[kind + 4]) / most_arrows); }
  run.observed_kinds = {
    position: most[0], velocity: most[1], force: most[2], held_position: most[4], held_velocity: most[5], held_force: most[6],
    largest: function (what) { return Math.max(longest[vector_kinds[what]], longest[vector_kinds[what] + 4]); },
    one_of: function (what) {
      const each = pitch(vector_kinds[what]);
      return each > 1 ? " (one of " + each + ")" : "";
    }
  };
  // Arrows of a frame at the nodes as they are drawn; see s.arrows.
  s.observed_arrows = function (what, frame, places) {
    const seen = run.observed(frame), kind = vector_kinds[what], each = pitch(kind), max = run.observed_kinds.largest(what), counts = [0, 0], found = [];
    if (!s.shown[what === "velocity" ? "velocities" : "reactions"]) return found;
    seen.nodes.forEach(function (node, k) {
      const held = seen.kinds[k] >= 4;
      if ((seen.kinds[k] & 3) !== kind || !(held ? s.shown.held_out : s.shown.observed)) return;
      if (counts[held ? 1 : 0]++ % each > 0 || node === run.never) return;
      const arrow = s.arrow_of(new THREE.Vector3().fromArray(places, 3 * node), new THREE.Vector3().fromArray(seen.points, 3 * k), max, null);
      if (arrow) found.push(Object.assign(arrow, { colour: held ? s.colours.held_out : s.colours[what === "velocity" ? "velocity" : "reaction"] }));
    });
    return found;
  };
  run.observed_frames = run.times.reduce(function (sum, _, frame) { return sum + (first[frame + 1] > first[frame] ? 1 : 0); }, 0);

  // longest: of an arrow alone
  s.observed_arrow_length = function (what, longest) {
    const seen = run.observed_kinds, count = what === "velocity" ? seen.velocity + seen.held_velocity : seen.force + seen.held_force;
    return s.length_of_many(longest, count);
  };

  // The layers of the picture that show them.
  s.LearnedLayers = function (spring_width, dot_size) {
    const colours = s.colours;
    const open = new s.Segments(run.springs, { width: spring_width, dash: 4 });
    const start = new s.Segments(run.springs, { width: Math.max(1, 0.5 * spring_width), opacity: 0.6 });
    const start_dots = new s.Dots(run.springs > 0 ? 0 : run.nodes), observed = new s.Dots(run.observed_most, 0.6), middles = new s.Dots(run.elements);
    const arrows = {}, group = new THREE.Group();
    ["velocity", "force"].forEach(function (what) {
      const seen = run.observed_kinds, each = what === "velocity" ? [seen.velocity, seen.held_velocity] : [seen.force, seen.held_force];
      arrows[what] = new s.ArrowShapes(Math.min(each[0], most_arrows) + Math.min(each[1], most_arrows), 0.6);
      group.add(arrows[what].group);
    });
    this.group = group;
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
      observed.mesh.visible = seen.held.length > 0;
      if (observed.mesh.visible) {
        observed.positions.set(seen.places);
        seen.held.forEach(function (held, k) { tint(observed, k, held ? colours.held_out : colours.observed, 0, dot_size + 7); });
        observed.mesh.geometry.setDrawRange(0, seen.held.length);
        observed.update();
      }
      ["velocity", "force"].forEach(function (what) {
        const all = s.observed_arrows(what, frame, positions);
        arrows[what].show(all, s.observed_arrow_length(what, s.camera.longest_arrow));
      });

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
