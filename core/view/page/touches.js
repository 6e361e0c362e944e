// Forces between bodies in contact as arrows: at each place two that begin there, one each way.
(function (s) {
  const run = s.run, numbers = 7;  // node near it or -1; x, y, z of the place, m; x, y, z of the force on the first body, N
  function force_of(touches, k) { return new THREE.Vector3().fromArray(touches, numbers * k + 4); }

  // One scale for all frames. An impact has many times the forces of bodies at rest: the longest arrow is what 95 % of the
  // forces do not exceed.
  const forces = [];
  let most = 0, frames = 0;
  for (let frame = 0; frame < run.frames; ++frame) {
    const touches = run.touches(frame), before = forces.length;
    for (let k = 0; numbers * k < touches.length; ++k) {
      const force = force_of(touches, k).length();
      if (force > 0) forces.push(force);
    }
    most = Math.max(most, forces.length - before);
    if (forces.length > before) ++frames;
  }
  const mean_count = frames > 0 ? forces.length / frames : 0;
  forces.sort(function (a, b) { return a - b; });
  const max_force = most > 0 ? forces[forces.length - 1] : 0, longest_force = most > 0 ? forces[Math.floor(0.95 * (forces.length - 1))] : 0;
  s.touches = { most: most, longest_force: longest_force, max_force: max_force };

  // Where bodies touch, moved with a node there if displacements are exaggerated; null if no such node is shown.
  function place_of(touches, k, real, drawn) {
    const place = new THREE.Vector3().fromArray(touches, numbers * k + 1), node = touches[numbers * k];
    if (s.exaggeration === 1) return place;
    if (node < 0) return null;
    return place.add(new THREE.Vector3().fromArray(drawn, 3 * node)).sub(new THREE.Vector3().fromArray(real, 3 * node));
  }
  // The arrows of a frame, `drawn`: the nodes as they are drawn. See s.arrow_of.
  s.touch_arrows = function (frame, drawn) {
    const touches = run.touches(frame), real = run.positions.row(frame), found = [];
    for (let k = 0; numbers * k < touches.length; ++k) {
      const place = place_of(touches, k, real, drawn), arrow = place && s.arrow_of(place, force_of(touches, k), longest_force, null);
      if (!arrow) continue;
      arrow.share = Math.min(1, arrow.share);
      found.push(arrow, Object.assign({}, arrow, { direction: arrow.direction.clone().negate() }));
    }
    return found;
  };
  s.touch_arrow_length = function (longest) { return s.length_of_many(longest, mean_count); };

  s.Touches = function () {
    const shapes = new s.ArrowShapes(2 * most, 1, s.colours.touch);
    this.group = shapes.group;
    this.show = function (frame, drawn) {
      shapes.show(s.touch_arrows(frame, drawn), s.touch_arrow_length(s.camera.longest_arrow));
    };
  };
})(springnet);
