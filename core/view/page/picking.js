// The node or spring under the pointer, and its values.
(function (s) {
  const run = s.run, point = new THREE.Vector3();

  // Screen coordinates of all nodes: x and y in pixels, and depth.
  function project(positions) {
    const view = document.getElementById("view"), camera = s.camera.camera;
    const out = new Float32Array(3 * run.nodes);
    for (let k = 0; k < run.nodes; ++k) {
      point.set(positions[3 * k], positions[3 * k + 1], positions[3 * k + 2]).project(camera);
      out[3 * k] = 0.5 * (1 + point.x) * view.clientWidth;
      out[3 * k + 1] = 0.5 * (1 - point.y) * view.clientHeight;
      out[3 * k + 2] = point.z;
    }
    return out;
  }

  function distance_to(places, a, b, x, y) {
    const ax = places[3 * a], ay = places[3 * a + 1], dx = places[3 * b] - ax, dy = places[3 * b + 1] - ay;
    const square = dx * dx + dy * dy;
    const share = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / square)) : 0;
    const depth = places[3 * a + 2] + share * (places[3 * b + 2] - places[3 * a + 2]);
    return { pixels: Math.hypot(x - ax - share * dx, y - ay - share * dy), depth: depth };
  }

  // Among the candidates near the pointer the one in front; each pixel of distance adds a little to its depth.
  s.pick_at = function (frame, x, y) {
    const positions = s.drawn_positions(frame), places = project(positions);
    let best = null, best_score = Infinity;
    function offer(pixels, max_pixels, depth, item) {
      if (pixels > max_pixels || depth > 1 || depth < -1) return;
      const score = depth + 2e-4 * pixels;
      if (score < best_score) { best_score = score; best = item; }
    }
    const paint = run.quantity(s.shown.colour).paint;
    if (paint && paint.of === "elements" && s.shown.learned) {
      const middle = [0, 0, 0], view = document.getElementById("view");
      for (let k = 0; k < run.elements; ++k) {
        run.middle_of(k, positions, middle, 0);
        point.fromArray(middle).project(s.camera.camera);
        offer(Math.hypot(0.5 * (1 + point.x) * view.clientWidth - x, 0.5 * (1 - point.y) * view.clientHeight - y), 9, point.z, { element: k });
      }
      if (best) return best;
    }
    if ((s.shown.nodes || !s.shown.springs) && !(run.is_learned && !s.shown.learned)) {
      for (let k = 0; k < run.nodes; ++k) {
        offer(Math.hypot(places[3 * k] - x, places[3 * k + 1] - y), 9, places[3 * k + 2], { node: k });
      }
    }
    if (best) return best;
    function offer_line(ends, k, item) {
      const found = distance_to(places, ends[2 * k], ends[2 * k + 1], x, y);
      offer(found.pixels, 6, found.depth, item);
    }
    for (let k = 0; k < run.springs; ++k) {
      if (s.is_drawn(k, frame, positions)) offer_line(run.ends, k, { spring: k });
    }
    for (let k = 0; 2 * k < run.rigids.length; ++k) offer_line(run.rigids, k, { rigid: k });
    return best;
  };

  // " of BODY, its NUMBER", or nothing for nodes and springs without a body.
  function membership(first, count, number) {
    const body = run.about.bodies.find(function (each) {
      return number >= each[first] && number - each[first] < each[count];
    });
    return body ? " of " + body.name + (body[first] > 0 ? ", its " + (number - body[first]) : "") : "";
  }

  // One unit for all lengths, chosen by the size of the network. Only significant digits are shown: a length is a
  // difference of coordinates, which the page stores in 16 or 32 bits.
  const unit = s.unit_for("m", s.camera.nodes_box.getSize(new THREE.Vector3()).length());
  const places_step = run.positions.step;
  function length_step(positions, a, b) {
    if (places_step > 0) return 2 * places_step;
    let max = 0;
    [a, b].forEach(function (node) {
      for (let k = 3 * node; k < 3 * node + 3; ++k) max = Math.max(max, Math.abs(positions[k]));
    });
    return 2 * s.float_step * max;
  }
  function numbers(values, size, step) {
    return Array.from(values).map(function (each) { return s.number(s.round_to(each, step) / size, 5); }).join(", ");
  }
  function length(value, step) { return numbers([value], unit[0], step) + " " + unit[1]; }
  function distance(positions, a, b) {
    return Math.hypot(positions[3 * a] - positions[3 * b], positions[3 * a + 1] - positions[3 * b + 1],
                      positions[3 * a + 2] - positions[3 * b + 2]);
  }
  function ends(list, k) { return run.node_numbers[list[2 * k]] + " and " + run.node_numbers[list[2 * k + 1]]; }
  // The sum of the loads on a node; null if the page does not have all of them.
  function force_on(node, frame) {
    if (run.about.forces !== run.arrow_nodes.length) return null;
    const forces = run.arrow_forces(frame), sum = [0, 0, 0], max = [0, 0, 0];
    run.arrow_nodes.forEach(function (each, k) {
      for (let axis = 0; each === node && axis < 3; ++axis) {
        sum[axis] += forces[3 * k + axis];
        max[axis] = Math.max(max[axis], Math.abs(forces[3 * k + axis]));
      }
    });
    // Forces that cancel leave only the rounding of their 32 bits.
    return sum.map(function (each, axis) { return Math.abs(each) <= 4 * s.float_step * max[axis] ? 0 : each; });
  }

  s.numbers_of = function (picked, frame) {
    const positions = run.positions.row(frame);
    if (picked.rigid !== undefined) {
      const a = run.rigids[2 * picked.rigid], b = run.rigids[2 * picked.rigid + 1];
      return [["rigid", "connection " + picked.rigid], ["nodes", ends(run.rigids, picked.rigid)],
              ["length", length(distance(positions, a, b), length_step(positions, a, b))]];
    }
    if (picked.element !== undefined)
      return [["element", run.element_numbers[picked.element]]].concat(s.learned_numbers("elements", picked.element));
    if (picked.node !== undefined) {
      const k = picked.node, states = ["free", "fixed", "moved by the scene"], force = force_on(k, frame);
      const rows = [["node", run.node_numbers[k] + membership("first_node", "nodes", run.node_numbers[k])],
                    ["position", numbers(positions.subarray(3 * k, 3 * k + 3), unit[0], places_step) + " " + unit[1]],
                    ["speed", s.number(s.round_to(run.speeds.row(frame)[k], run.speeds.step)) + " m/s"],
                    ["mass", s.number(run.masses[k]) + " kg"],
                    ["state", states[run.kinds[k]] + (run.in_contact(frame, k) ? ", in contact" : "")]];
      if (force && Math.hypot(force[0], force[1], force[2]) > 0) rows.push(["force", numbers(force, 1, 0) + " N"]);
      return run.is_learned ? rows.concat(s.learned_numbers("nodes", k)) : rows;
    }
    const k = picked.spring, a = run.ends[2 * k], b = run.ends[2 * k + 1];
    const now = distance(positions, a, b), rest = run.rest_lengths[k], step = length_step(positions, a, b) + s.float_step * rest;
    const rows = [["spring", run.spring_numbers[k] + membership("first_spring", "springs", run.spring_numbers[k])],
                  ["nodes", ends(run.ends, k)],
                  ["length", length(now, step)],
                  ["at rest", length(rest, 0)],
                  ["stretch", rest > 0 ? s.number(s.round_to(100 * (now / rest - 1), 100 * step / rest), 3) + " %" : "–"]];
    if (frame >= run.removal_frames[k]) {
      const removal = run.removals.get(k);
      rows.push(["state", removal.how + " at " + s.number(removal.time, 5) + " s"]);
    } else {
      rows.push(["tension", s.number(s.round_to(run.tensions.row(frame)[k], run.tensions.step)) + " N"]);
    }
    run.about.material_states[run.materials[k]].forEach(function (which) {
      const state = run.about.states[which];
      rows.push([state.label, s.number(run.state(frame, k, which), 5) + (state.unit ? " " + state.unit : "")]);
    });
    if (run.is_learned) return rows.concat(s.learned_numbers("springs", k));
    rows.push(["law", run.about.materials[run.materials[k]]]);
    return rows;
  };

  s.show_picked = function (frame) {
    const place = document.getElementById("picked");
    place.textContent = "";
    if (!s.picked) {
      place.textContent = "Click a node or a spring to see its values.";
      return;
    }
    const table = document.createElement("table");
    s.numbers_of(s.picked, frame).forEach(function (row) {
      const line = table.insertRow();
      line.insertCell().textContent = row[0];
      line.insertCell().textContent = row[1];
    });
    place.append(table);
  };
})(springnet);
