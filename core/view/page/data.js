// Reads the run from the page: each block of numbers is base64 in an element of its own.
(function (s) {
  s.float_step = Math.pow(2, -24);  // relative rounding of 32 bit floats
  // A page with several motions has a template with the elements of each further one; "#experiment=2" is the first of them.
  const titles = JSON.parse(document.getElementById("description").textContent).motions;
  const wanted = Number(new URLSearchParams(location.hash.slice(1)).get("experiment"));
  const motion = Number.isInteger(wanted) && wanted >= 1 && wanted <= titles.length ? wanted : 1;
  const elements = motion > 1 ? document.getElementById("motion" + motion).content : document;
  const about = JSON.parse(elements.getElementById("description").textContent);
  s.motions = { titles: titles, shown: motion };

  function block(name, Type) {
    const element = elements.getElementById(name);
    const text = atob(element.textContent);
    element.textContent = "";
    const bytes = new Uint8Array(text.length);
    for (let k = 0; k < bytes.length; ++k) bytes[k] = text.charCodeAt(k);
    return new Type(bytes.buffer);
  }

  // Rows of `width` numbers, one per frame; row(frame) is valid until the next call. `step`: resolution of numbers that
  // are rounded to 16 bits; else 0.
  function rows(name, width) {
    if (!about.rounded) {
      const numbers = block(name, Float32Array);
      return {
        row: function (frame) { return numbers.subarray(frame * width, (frame + 1) * width); },
        numbers: numbers.length, at: function (k) { return numbers[k]; }, step: 0
      };
    }
    const range = block(name + "_range", Float32Array);
    const shares = block(name, Uint16Array);
    const scale = (range[1] - range[0]) / 65535;
    // A symmetric range has an even number of values, 0 to 65535, none of which is 0: the two nearest stand for it.
    const middle = range[0] === -range[1] && range[1] > 0;
    function at(k) {
      const value = range[0] + shares[k] * scale;
      return middle && Math.abs(value) < 0.51 * scale ? 0 : value;
    }
    const out = new Float32Array(width);
    let cached = -1;
    return {
      row: function (frame) {
        if (frame !== cached) {
          const first = frame * width;
          for (let k = 0; k < width; ++k) out[k] = at(first + k);
          cached = frame;
        }
        return out;
      },
      numbers: shares.length, at: at, step: scale
    };
  }

  const nodes = about.shown_nodes, springs = about.shown_springs, surfaces = about.surfaces.length;
  const run = {
    about: about, frames: about.frames, nodes: nodes, springs: springs,
    node_numbers: block("node_numbers", Uint32Array), masses: block("node_masses", Float32Array),
    kinds: block("node_kinds", Uint8Array),  // 0 free, 1 fixed, 2 moved
    spring_numbers: block("spring_numbers", Uint32Array), ends: block("spring_ends", Uint32Array),
    rest_lengths: block("spring_rest_lengths", Float32Array), materials: block("spring_materials", Uint32Array),
    rigids: block("rigid_ends", Uint32Array),
    faces: block("faces", Uint32Array), face_frames: block("face_frames", Uint32Array),
    positions: rows("positions", 3 * nodes), speeds: rows("speeds", nodes), tensions: rows("tensions", springs)
  };
  run.block = block;
  run.rows = rows;
  // Internal states of laws, spring by spring: those of its material, which are numbers in about.states.
  run.states = { numbers: block("states", Float32Array), first: new Uint32Array(springs), width: 0 };
  const material_states = about.material_states;
  for (let k = 0; k < springs; ++k) {
    run.states.first[k] = run.states.width;
    run.states.width += material_states[run.materials[k]].length;
  }
  // Of spring k; null if it does not have this state.
  run.state = function (frame, k, which) {
    const place = material_states[run.materials[k]].indexOf(which);
    return place < 0 ? null : run.states.numbers[frame * run.states.width + run.states.first[k] + place];
  };
  // x, y, z of each load's resultant and of each arrow at a node, N
  run.arrow_nodes = block("arrow_nodes", Uint32Array);
  run.all_resultants = block("load_resultants", Float32Array);
  run.all_arrow_forces = block("arrow_forces", Float32Array);
  function vectors(all) {
    const width = all.length / run.frames;
    return function (frame) { return all.subarray(frame * width, (frame + 1) * width); };
  }
  run.resultants = vectors(run.all_resultants);
  run.arrow_forces = vectors(run.all_arrow_forces);
  run.touches = vectors(block("touches", Float32Array));  // of bodies, see s.touch_arrows
  const contact = block("contact", Uint8Array), contact_width = Math.ceil(nodes / 8);
  run.in_contact = function (frame, node) { return (contact[frame * contact_width + (node >> 3)] >> (node & 7) & 1) === 1; };
  run.has_contact = contact.some(function (byte) { return byte !== 0; });
  // Pose of a surface: x, y, z, m; the quaternion x, y, z, w of its rotation since the start.
  const poses = block("surface_poses", Float32Array);
  run.surface = function (frame, k) { return poses.subarray(7 * (frame * surfaces + k), 7 * (frame * surfaces + k) + 7); };

  const scalars = block("scalars", Float64Array), width = scalars.length / run.frames;
  function column(k) { return Array.from({ length: run.frames }, function (_, frame) { return scalars[frame * width + k]; }); }
  run.times = column(0);
  run.kinetic = column(1);
  run.potential = column(2);
  run.steps = column(3);
  run.sweeps = column(4);
  run.events = ["cut", "ruptured", "touched", "released", "slipped", "stuck", "jammed", "met", "parted"].map(function (name, k) {
    return { name: name, counts: column(5 + k) };
  });
  run.curves = about.curves.map(function (curve, k) { return Object.assign({ values: column(14 + k) }, curve); });

  // Whether the integrator chooses its own steps, within which records may lie: CVODE, and others if records show it.
  run.internal_steps = about.integrator === "cvode" ||
    run.steps.some(function (steps, k) { return k > 0 && steps === run.steps[k - 1] && run.times[k] > run.times[k - 1]; });

  // The first frame without each spring; `never` for those that stay.
  run.never = 0xffffffff;
  run.removal_frames = new Uint32Array(springs).fill(run.never);
  run.removals = new Map();
  const removed = block("removed_springs", Uint32Array), frames = block("removed_frames", Uint32Array);
  const times = block("removed_times", Float64Array), kinds = block("removed_kinds", Uint8Array);
  for (let k = 0; k < removed.length; ++k) {
    run.removal_frames[removed[k]] = frames[k];
    run.removals.set(removed[k], { time: times[k], how: kinds[k] ? "ruptured" : "cut" });
  }

  // Whether all nodes of a frame are within 15 sizes of the network from its start. The other frames belong to a diverging
  // run, and are left out when ranges of colours are found.
  function frames_nearby() {
    let low = Infinity, high = -Infinity;
    run.positions.row(0).forEach(function (value) { low = Math.min(low, value); high = Math.max(high, value); });
    const reach = 15 * (high - low), width = 3 * nodes;
    return run.times.map(function (_, frame) {
      for (let k = frame * width; reach > 0 && k < (frame + 1) * width; ++k) {
        const value = run.positions.at(k);
        if (value < low - reach || value > high + reach) return false;
      }
      return true;
    });
  }
  const nearby = frames_nearby();

  // Range of colours for numbers of all frames; null: no number. Single peaks must not compress the colour scale: it shows
  // what 99.5 % of a sample of the magnitudes do not exceed. `symmetric` if there are both signs.
  function range(per_frame, at) {
    const numbers = run.frames * per_frame, stride = Math.max(1, Math.floor(numbers / 200000)), sample = [];
    let max = 0, low = 0;
    for (let frame = 0, k = 0; frame < run.frames; ++frame) {
      for (let place = 0; place < per_frame; ++place, ++k) {
        const value = at(frame, place);
        if (value === null) continue;
        max = Math.max(max, Math.abs(value));
        low = Math.min(low, value);
        if (k % stride === 0 && nearby[frame]) sample.push(Math.abs(value));
      }
    }
    sample.sort(function (a, b) { return a - b; });
    const common = sample.length ? sample[Math.min(sample.length - 1, Math.floor(0.995 * sample.length))] : 0;
    return { max: max, shown: max > 0 ? s.round_up(common > 0 ? common : max) : 0, symmetric: low < 0 };
  }
  function range_of(values) {
    const width = values.numbers / run.frames;
    return range(width, function (frame, k) { return values.at(frame * width + k); });
  }
  run.tension_range = range_of(run.tensions);
  run.speed_range = range_of(run.speeds);

  // What colours show: value in s.shown.colour; `of_state`: number in about.states.
  const state_ranges = [];
  // `paint`: learned values, the same at all times.
  run.quantity = function (name) {
    if (name.startsWith("learned")) {
      const paint = s.paint(name);
      return { title: paint.title, unit: paint.unit, paint: paint };
    }
    if (name.startsWith("state")) {
      const which = Number(name.slice(5)), state = about.states[which];
      const found = state_ranges[which] || (state_ranges[which] =
        range(springs, function (frame, k) { return run.state(frame, k, which); }));
      return { title: state.label, unit: state.unit, range: found, symmetric: found.symmetric, of_state: which };
    }
    const tension = name === "tension";
    return { title: tension ? "tension of springs" : "speed", unit: tension ? "N" : "m/s",
             range: tension ? run.tension_range : run.speed_range, symmetric: tension };
  };

  // The last frame that is not after the time.
  run.frame_at = function (time) {
    let low = 0, high = run.frames - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (run.times[middle] <= time + 1e-9 * Math.abs(time)) low = middle; else high = middle - 1;
    }
    return low;
  };
  s.run = run;
  // What is drawn, and how. Set by the page's address and the panel.
  s.shown = { springs: true, broken: true, nodes: nodes <= 20000, faces: true, instruments: true, forces: true, touches: true,
              held_out: true, velocities: true, reactions: true, arrows: "resultants", colour: "tension" };
})(springnet);
