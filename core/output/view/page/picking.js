// The node or spring under the pointer, and its numbers.
(function (s) {
  const run = s.run, point = new THREE.Vector3();

  // Places on the screen in pixels, and depth, of all nodes.
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

  // Of those within reach the one in front; a pixel of distance counts like a little depth.
  s.pick_at = function (frame, x, y) {
    const places = project(run.positions.row(frame));
    let best = null, least = Infinity;
    function offer(pixels, reach, depth, what) {
      if (pixels > reach || depth > 1 || depth < -1) return;
      const score = depth + 2e-4 * pixels;
      if (score < least) { least = score; best = what; }
    }
    if (s.shown.nodes || !s.shown.springs) {
      for (let k = 0; k < run.nodes; ++k) {
        offer(Math.hypot(places[3 * k] - x, places[3 * k + 1] - y), 9, places[3 * k + 2], { node: k });
      }
    }
    if (best || !(s.shown.springs || s.shown.broken)) return best;
    for (let k = 0; k < run.springs; ++k) {
      if (frame >= run.gone[k] ? !s.shown.broken : !s.shown.springs) continue;
      const found = distance_to(places, run.ends[2 * k], run.ends[2 * k + 1], x, y);
      offer(found.pixels, 6, found.depth, { spring: k });
    }
    return best;
  };

  function member(first, count, number) {
    const body = run.about.bodies.find(function (each) {
      return number >= each[first] && number - each[first] < each[count];
    });
    return body ? " of " + body.name + (body[first] > 0 ? ", its " + (number - body[first]) : "") : "";
  }
  function vector(values) { return Array.from(values).map(function (each) { return s.number(each, 5); }).join(", "); }

  s.numbers_of = function (picked, frame) {
    const positions = run.positions.row(frame);
    if (picked.node !== undefined) {
      const k = picked.node, states = ["free", "fixed", "moved by the scene"];
      return [["node", run.node_numbers[k] + member("first_node", "nodes", run.node_numbers[k])],
              ["position", vector(positions.subarray(3 * k, 3 * k + 3)) + " m"],
              ["speed", s.number(run.speeds.row(frame)[k]) + " m/s"],
              ["mass", s.number(run.masses[k]) + " kg"],
              ["state", states[run.kinds[k]] + (run.touches(frame, k) ? ", in contact" : "")]];
    }
    const k = picked.spring, a = run.ends[2 * k], b = run.ends[2 * k + 1];
    const length = Math.hypot(positions[3 * a] - positions[3 * b], positions[3 * a + 1] - positions[3 * b + 1],
                              positions[3 * a + 2] - positions[3 * b + 2]);
    const rows = [["spring", run.spring_numbers[k] + member("first_spring", "springs", run.spring_numbers[k])],
                  ["nodes", run.node_numbers[a] + " and " + run.node_numbers[b]],
                  ["length", s.number(length, 5) + " m"],
                  ["at rest", s.number(run.rests[k], 5) + " m"],
                  ["stretch", run.rests[k] > 0 ? s.number(100 * (length / run.rests[k] - 1), 3) + " %" : "–"]];
    if (frame >= run.gone[k]) {
      const removal = run.removals.get(k);
      rows.push(["state", removal.how + " at " + s.number(removal.time, 5) + " s"]);
    } else {
      rows.push(["tension", s.number(run.tensions.row(frame)[k]) + " N"]);
    }
    rows.push(["law", run.about.materials[run.materials[k]]]);
    return rows;
  };

  s.show_picked = function (frame) {
    const place = document.getElementById("picked");
    place.textContent = "";
    if (!s.picked) {
      place.textContent = "Click a node or a spring.";
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
