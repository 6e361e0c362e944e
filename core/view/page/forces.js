// The loads of the scene as arrows: the resultant of each, or the forces on its nodes.
(function (s) {
  const run = s.run, loads = run.about.loads;
  let first = 0;
  loads.forEach(function (load) { load.first = first; first += load.arrows; });
  function vector(values, k) { return new THREE.Vector3().fromArray(values, 3 * k); }
  function largest(values) {
    let max = 0;
    for (let k = 0; k < values.length; k += 3) max = Math.max(max, Math.hypot(values[k], values[k + 1], values[k + 2]));
    return max;
  }

  // Arrows lie outside the body: those that push inwards end at the node they act on, the others begin there.
  const start = run.positions.row(0), middle = new THREE.Vector3();
  for (let k = 0; k < start.length; k += 3) middle.add(new THREE.Vector3(start[k], start[k + 1], start[k + 2]));
  middle.multiplyScalar(1 / Math.max(1, run.nodes));
  function arrow_of(place, force, max, origin) {
    const size = force.length();
    if (!(size > 0) || !(max > 0)) return null;
    const direction = force.clone().multiplyScalar(1 / size);
    // At least a fifth of the longest one, so that small forces are visible.
    return { place: place, direction: direction, share: Math.max(0.2, size / max),
             inward: origin !== null && middle.clone().sub(origin).dot(direction) > 0 };
  }
  s.arrow_of = arrow_of;  // origin null: it begins at its place
  function node_place(k, places) { return vector(places, run.arrow_nodes[k]); }
  // Where the resultant of a load acts: the mean of its arrows' nodes, weighted by the forces there.
  function centre_of(load, forces, places) {
    const centre = new THREE.Vector3();
    let sum = 0;
    for (let k = load.first; k < load.first + load.arrows; ++k) {
      const weight = vector(forces, k).length();
      centre.addScaledVector(node_place(k, places), weight);
      sum += weight;
    }
    return sum > 0 ? centre.multiplyScalar(1 / sum) : centre;
  }
  const origins = {
    resultants: loads.map(function (load) { return centre_of(load, new Float32Array(3 * first).fill(1), start); }),
    nodes: Array.from(run.arrow_nodes, function (node) { return vector(start, node); })
  };
  // The largest force of the whole run sets one scale for all frames.
  const max_force = { resultants: largest(run.all_resultants), nodes: largest(run.all_arrow_forces) };
  const count = { resultants: loads.length, nodes: first };
  s.arrow_modes = { max_force: max_force, differ: first > loads.length };

  // The arrows of a frame, null for forces that are zero. `share`: of the longest arrow, at least 0.2.
  s.arrows = function (mode, frame, places) {
    const forces = run.arrow_forces(frame);
    if (mode === "nodes") {
      return origins.nodes.map(function (origin, k) { return arrow_of(node_place(k, places), vector(forces, k), max_force.nodes, origin); });
    }
    const resultants = run.resultants(frame);
    return loads.map(function (load, k) {
      return arrow_of(centre_of(load, forces, places), vector(resultants, k), max_force.resultants, origins.resultants[k]);
    });
  };
  // The length of the longest arrow. The more arrows there are, the shorter all of them, to leave the body visible.
  s.length_of_many = function (longest, count) { return longest * Math.min(1, Math.max(0.3, 3 / Math.sqrt(Math.max(1, count)))); };
  s.arrow_length = function (mode, longest) { return s.length_of_many(longest, count[mode]); };
  s.arrow_start = function (arrow, length) {
    return arrow.inward ? arrow.place.clone().addScaledVector(arrow.direction, -arrow.share * length) : arrow.place.clone();
  };

  // Shapes of up to so many arrows, of a colour of their own or this one; width: of the shaft, as a share of a load's.
  s.ArrowShapes = function (capacity, width_share, common) {
    const group = new THREE.Group(), arrow_axis = new THREE.Vector3(0, 1, 0), materials = new Map();
    const outline = [[0, 0], [0.018, 0], [0.018, 0.72], [0.06, 0.72], [0, 1]].map(function (each) {
      return new THREE.Vector2(each[0], each[1]);
    });
    const shape = new THREE.LatheBufferGeometry(outline, 20);
    // Arrows behind the body show through it.
    function materials_of(rgb) {
      const name = "rgb(" + rgb.join(",") + ")", colour = new THREE.Color(name);
      if (!materials.has(name)) {
        materials.set(name, [new THREE.MeshPhongMaterial({ color: colour, shininess: 20 }),
          new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.55, depthTest: false, depthWrite: false })]);
      }
      return materials.get(name);
    }
    const parts = Array.from({ length: capacity }, function () {
      const part = new THREE.Mesh(shape), shadow = new THREE.Mesh(shape);
      shadow.renderOrder = 4;
      part.add(shadow);
      group.add(part);
      return part;
    });
    this.group = group;
    this.show = function (arrows, length) {
      parts.forEach(function (part, k) {
        const arrow = arrows[k];
        part.visible = Boolean(arrow);
        if (!arrow) return;
        [part.material, part.children[0].material] = materials_of(arrow.colour || common);
        const width = width_share * Math.sqrt(arrow.share) * length;
        part.scale.set(width, arrow.share * length, width);
        part.quaternion.setFromUnitVectors(arrow_axis, arrow.direction);
        part.position.copy(s.arrow_start(arrow, length));
      });
    };
  };

  s.Forces = function () {
    const shapes = new s.ArrowShapes(Math.max(count.nodes, count.resultants), 1, s.colours.force);
    this.group = shapes.group;
    this.show = function (frame, places) {
      shapes.show(s.arrows(s.shown.arrows, frame, places), s.arrow_length(s.shown.arrows, s.camera.longest_arrow));
    };
  };
})(springnet);
