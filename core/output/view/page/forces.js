// The forces of the scene as arrows: which act when, and where they lie.
(function (s) {
  const run = s.run, loads = run.about.loads, slack = 1e-6 * run.about.time_step;

  s.acts = function (load, frame) {
    const time = run.times[frame] + slack;
    return (load.from === null || time >= load.from) && (load.until === null || time < load.until);
  };

  // Those that push inwards end at their node, the others begin there: arrows lie outside of what they act on.
  const first = run.positions.row(0), middle = new THREE.Vector3();
  for (let k = 0; k < first.length; k += 3) middle.add(new THREE.Vector3(first[k], first[k + 1], first[k + 2]));
  middle.multiplyScalar(1 / Math.max(1, run.nodes));
  const most = loads.reduce(function (size, load) { return Math.max(size, new THREE.Vector3().fromArray(load.force).length()); }, 0);
  const arrows = loads.map(function (load) {
    const force = new THREE.Vector3().fromArray(load.force), size = force.length();
    const inward = middle.clone().sub(new THREE.Vector3().fromArray(first, 3 * load.node)).dot(force) > 0;
    // Small ones as well have to be seen.
    return { node: load.node, direction: force.multiplyScalar(1 / size), share: Math.max(0.2, size / most), inward: inward };
  });

  // The greatest force is `longest` long.
  s.arrow = function (k, positions, longest) {
    const arrow = arrows[k], node = new THREE.Vector3().fromArray(positions, 3 * arrow.node);
    const length = arrow.share * longest, start = node.clone();
    if (arrow.inward) start.addScaledVector(arrow.direction, -length);
    return { node: node, start: start, direction: arrow.direction, length: length };
  };

  s.Forces = function () {
    const group = new THREE.Group(), along = new THREE.Vector3(0, 1, 0), longest = s.camera.longest_arrow;
    const outline = [[0, 0], [0.018, 0], [0.018, 0.72], [0.06, 0.72], [0, 1]].map(function (each) {
      return new THREE.Vector2(each[0], each[1]);
    });
    const shape = new THREE.LatheBufferGeometry(outline, 20);
    const colour = new THREE.Color("rgb(" + s.colours.force.join(",") + ")");
    const material = new THREE.MeshPhongMaterial({ color: colour, shininess: 20 });
    // What is behind the body shows through it.
    const hidden = new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.55, depthTest: false, depthWrite: false });
    const parts = loads.map(function (_, k) {
      const part = new THREE.Mesh(shape, material), shadow = new THREE.Mesh(shape, hidden);
      shadow.renderOrder = 4;
      part.add(shadow);
      part.quaternion.setFromUnitVectors(along, arrows[k].direction);
      const width = Math.sqrt(arrows[k].share) * longest;
      part.scale.set(width, arrows[k].share * longest, width);
      group.add(part);
      return part;
    });
    this.group = group;
    this.show = function (frame, positions) {
      parts.forEach(function (part, k) {
        part.visible = s.acts(loads[k], frame);
        if (part.visible) part.position.copy(s.arrow(k, positions, longest).start);
      });
    };
  };
})(springnet);
