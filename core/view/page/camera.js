// The camera: up is against gravity, and the whole motion is in view.
(function (s) {
  const run = s.run, surfaces = run.about.surfaces;

  function diagonal(box) { return box.getSize(new THREE.Vector3()).length(); }
  function motion_box() {
    const box = new THREE.Box3(), point = new THREE.Vector3();
    for (let k = 0; k < run.positions.numbers; k += 3) {
      box.expandByPoint(point.set(s.drawn_coordinate(k), s.drawn_coordinate(k + 1), s.drawn_coordinate(k + 2)));
    }
    for (let frame = 0; run.start_positions && frame < run.frames; ++frame) {
      const row = s.drawn_start(frame), seen = s.drawn_observed(frame);
      for (let k = 0; k < row.length; k += 3) box.expandByPoint(point.set(row[k], row[k + 1], row[k + 2]));
      for (let k = 0; k < seen.length; k += 3) box.expandByPoint(point.set(seen[k], seen[k + 1], seen[k + 2]));
    }
    if (box.isEmpty()) box.expandByPoint(new THREE.Vector3());
    return box;
  }
  // Leaves out pieces that fly far away, which would reduce the rest to a dot.
  function without_outliers(whole) {
    const start = new THREE.Box3().setFromArray(Array.from(run.positions.row(0)));
    const size = diagonal(start);
    if (!(size > 0) || diagonal(whole) < 3.5 * size) return whole;
    return whole.intersect(start.expandByScalar(0.8 * size));
  }
  // Boxes about the ends of instruments, as far as these are near the nodes: they are in view, too.
  function instrument_boxes(nodes_box) {
    const near = nodes_box.clone().expandByScalar(0.4 * Math.max(diagonal(nodes_box), 1e-9)), boxes = [];
    surfaces.forEach(function (surface, k) {
      if (surface.kind === "plane") return;
      const is_box = surface.kind === "box";
      const half_size = new THREE.Vector3().setScalar(is_box ? 0.5 * new THREE.Vector3().fromArray(surface.size).length() : surface.radius);
      const to = new THREE.Vector3();
      if (!is_box) to.fromArray(surface.to).sub(new THREE.Vector3().fromArray(surface.point));
      for (let frame = 0; frame < run.frames; ++frame) {
        const pose = run.surface(frame, k), first = new THREE.Vector3().fromArray(pose);
        const rotation = new THREE.Quaternion().fromArray(pose, 3);
        [first, first.clone().add(to.clone().applyQuaternion(rotation))].forEach(function (end) {
          const each = new THREE.Box3(end.clone().sub(half_size), end.clone().add(half_size)).intersect(near);
          if (!each.isEmpty()) boxes.push(each);
        });
      }
    });
    return boxes;
  }
  // Ends of the arrows of forces, which are in view while they act.
  function arrow_ends(nodes_box, longest) {
    const ends = [], mode = s.shown.arrows, length = s.arrow_length(mode, longest);
    const stride = Math.max(1, Math.ceil(run.frames * run.arrow_nodes.length / 5000));
    for (let frame = 0; run.arrow_nodes.length > 0 && frame < run.frames; frame += stride) {
      s.arrows(mode, frame, s.drawn_positions(frame)).forEach(function (arrow) {
        if (!arrow || !nodes_box.containsPoint(arrow.place)) return;
        const start = s.arrow_start(arrow, length);
        ends.push(start, start.clone().addScaledVector(arrow.direction, arrow.share * length));
      });
    }
    return ends.concat(observed_ends(nodes_box, longest), touch_ends(nodes_box, longest));
  }
  // Of velocities and forces that were observed.
  function observed_ends(nodes_box, longest) {
    const ends = [], most = run.observed_kinds ? run.observed_most : 0, stride = Math.max(1, Math.ceil(run.frames * most / 5000));
    for (let frame = 0; most > 0 && frame < run.frames; frame += stride) {
      ["velocity", "force"].forEach(function (what) {
        const length = s.observed_arrow_length(what, longest);
        s.observed_arrows(what, frame, s.drawn_positions(frame)).forEach(function (arrow) {
          if (nodes_box.containsPoint(arrow.place)) ends.push(arrow.place.clone().addScaledVector(arrow.direction, arrow.share * length));
        });
      });
    }
    return ends;
  }

  // Of forces between bodies. The box of nodes in a line or a plane is flat: places beside it by rounding count as inside.
  function touch_ends(nodes_box, longest) {
    const ends = [], count = 2 * s.touches.most, length = s.touch_arrow_length(longest), stride = Math.max(1, Math.ceil(run.frames * count / 5000));
    const near = nodes_box.clone().expandByScalar(1e-3 * diagonal(nodes_box));
    for (let frame = 0; count > 0 && frame < run.frames; frame += stride) {
      s.touch_arrows(frame, s.drawn_positions(frame)).forEach(function (arrow) {
        if (near.containsPoint(arrow.place)) ends.push(arrow.place.clone().addScaledVector(arrow.direction, arrow.share * length));
      });
    }
    return ends;
  }

  function gcd(a, b) { return b === 0 ? a : gcd(b, a % b); }

  // What has to be in view: centre and radius of its box, and relative to the centre a sample of the nodes of all frames,
  // corners of the boxes above, and ends of arrows.
  function find_bounds() {
    const nodes_box = without_outliers(motion_box()), longest = 0.16 * diagonal(nodes_box) || 0.3, box = nodes_box.clone();
    const boxes = instrument_boxes(nodes_box), ends = arrow_ends(nodes_box, longest), points = [];
    boxes.forEach(function (each) { box.union(each); });
    ends.forEach(function (end) { box.expandByPoint(end); });
    const centre = box.getCenter(new THREE.Vector3());
    // Every stride-th position; coprime to the number of nodes, so that every node is sampled.
    let stride = Math.max(1, Math.floor(run.positions.numbers / 3 / 20000));
    while (gcd(stride, run.nodes) > 1) ++stride;
    for (let k = 0; k < run.positions.numbers; k += 3 * stride) {
      const place = new THREE.Vector3(s.drawn_coordinate(k), s.drawn_coordinate(k + 1), s.drawn_coordinate(k + 2));
      if (box.containsPoint(place)) points.push(place.sub(centre));
    }
    const more = [];
    for (let frame = 0; run.start_positions && frame < run.frames; frame += Math.max(1, stride >> 3)) {
      more.push(Float32Array.from(s.drawn_start(frame)), Float32Array.from(s.drawn_observed(frame).places));
    }
    more.forEach(function (row) {
      for (let k = 0; k < row.length; k += 3 * stride) {
        const place = new THREE.Vector3(row[k], row[k + 1], row[k + 2]);
        if (box.containsPoint(place)) points.push(place.sub(centre));
      }
    });
    boxes.forEach(function (each) { points.push(each.min.clone().sub(centre), each.max.clone().sub(centre)); });
    ends.forEach(function (end) { points.push(end.clone().sub(centre)); });
    return { nodes_box: nodes_box, longest_arrow: longest, centre: centre, radius: 0.5 * diagonal(box) || 1, points: points };
  }
  let bounds = find_bounds();
  const nodes_box = bounds.nodes_box;

  function axis(k) { return new THREE.Vector3().setComponent(k, 1); }
  function flat_axis() {
    const size = nodes_box.getSize(new THREE.Vector3()).toArray();
    const max = Math.max.apply(null, size);
    const k = size.indexOf(Math.min.apply(null, size));
    return max > 0 && size[k] < 1e-3 * max && size.filter(function (each) { return each < 1e-3 * max; }).length === 1 ? k : -1;
  }
  const flat = flat_axis();
  const gravity = new THREE.Vector3().fromArray(run.about.gravity);
  let up = flat === 2 ? 1 : 2;
  let sign = 1;
  if (gravity.length() > 0) {
    const components = gravity.toArray().map(Math.abs);
    up = components.indexOf(Math.max.apply(null, components));
    sign = gravity.getComponent(up) > 0 ? -1 : 1;
  }
  const upward = axis(up).multiplyScalar(sign);
  // Azimuth is counted about the up axis from `ahead`.
  const ahead = axis((up + 1) % 3), aside = new THREE.Vector3().crossVectors(upward, ahead);

  const default_view = { azimuth: -62, elevation: 18 };
  if (flat >= 0 && flat !== up) {
    default_view.azimuth = flat === (up + 1) % 3 ? 0 : sign * -90;
    default_view.elevation = 0;
    if (up === 1 && flat === 2) default_view.azimuth = 0;
  }

  const camera = new THREE.PerspectiveCamera(32, 1, bounds.radius / 100, bounds.radius * 60);
  camera.up.copy(upward);
  const target = new THREE.Vector3();

  // Rectangles that cover the picture, [left, top, right, bottom] in pixels: time and legend above, scale and axes below.
  // The text of the scale depends on the distance, so its usual width is assumed.
  function overlays(width, height) {
    function rectangle_of(id) {
      const label = document.getElementById(id);
      return [label.offsetLeft, label.offsetTop, label.offsetLeft + label.offsetWidth, label.offsetTop + label.offsetHeight];
    }
    if (document.body.classList.contains("no-labels")) return { above: [], below: [] };
    const scale = surfaces.some(function (each) { return each.kind === "plane"; }) ? 250 : 170;
    return { above: [rectangle_of("clock"), rectangle_of("legend")].filter(function (each) { return each[3] > each[1] && each[1] < height; }),
             below: [[0, height - 48, Math.min(scale, width - 100), height], [width - 96, height - 96, width, height]] };
  }

  // The distance at which everything just fits, with a margin, seen from the direction `toward`; and by how many pixels
  // the picture is moved down. Strips above and below are kept free if the labels there would cover something.
  function fit(toward) {
    const view = document.getElementById("view"), width = Math.max(1, view.clientWidth), height = Math.max(1, view.clientHeight);
    const right = new THREE.Vector3().crossVectors(upward, toward).normalize();
    const vertical = new THREE.Vector3().crossVectors(toward, right);
    const half = Math.tan(camera.fov * Math.PI / 360), aspect = width / height;
    const places = bounds.points.map(function (place) { return [place.dot(right), place.dot(vertical), place.dot(toward)]; });
    const overlaid = overlays(width, height), all = overlaid.above.concat(overlaid.below);
    const top = Math.min(0.3 * height, overlaid.above.reduce(function (max, each) { return Math.max(max, each[3]); }, 0));
    const bottom = Math.min(0.15 * height, overlaid.below.reduce(function (max, each) { return Math.max(max, height - each[1]); }, 0));

    function with_strips(share) {
      const slope = half * (0.86 + 0.1 * share) * (1 - share * (top + bottom) / height);
      let distance = 1e-3 * bounds.radius;
      places.forEach(function (place) {
        const clearance = Math.max(Math.abs(place[1]) / slope, Math.abs(place[0]) / (0.86 * half * aspect));
        distance = Math.max(distance, place[2] + clearance);
      });
      return { distance: distance, down: share * (top - bottom) / 2 };
    }
    function is_covered(found) {
      return places.some(function (place) {
        const depth = half * (found.distance - place[2]);
        const x = width / 2 * (1 + place[0] / (depth * aspect)), y = height / 2 * (1 - place[1] / depth) + found.down;
        return all.some(function (each) { return x > each[0] && x < each[2] && y > each[1] && y < each[3]; });
      });
    }
    let found = with_strips(0);
    for (let k = 1; k <= 6 && all.length > 0 && is_covered(found); ++k) found = with_strips(k / 6);
    return found;
  }
  let down = 0;
  function update_size() {
    const view = document.getElementById("view"), width = Math.max(1, view.clientWidth), height = Math.max(1, view.clientHeight);
    camera.setViewOffset(width, height, 0, -down, width, height);  // sets the aspect too
  }

  s.camera = {
    depth: new THREE.Vector2(0, 1),  // nearest and farthest distance of the motion from the camera; see update_depth()
    update_depth: function () {
      const distance = camera.position.distanceTo(bounds.centre);
      this.depth.set(Math.max(0, distance - 0.8 * bounds.radius), distance + 0.8 * bounds.radius);
    },
    camera: camera, target: target, longest_arrow: bounds.longest_arrow,
    centre: bounds.centre, radius: bounds.radius, upward: upward, flat: flat, nodes_box: nodes_box,
    // Call it when positions are drawn in another way; look() then brings them into view.
    update_bounds: function () {
      bounds = find_bounds();
      camera.far = Math.max(camera.far, 60 * bounds.radius);
      camera.updateProjectionMatrix();
    },
    // Degrees; zoom 1 shows the whole motion.
    look: function (azimuth, elevation, zoom) {
      const a = azimuth * Math.PI / 180, e = Math.min(89.9, Math.max(-89.9, elevation)) * Math.PI / 180;
      const toward = ahead.clone().multiplyScalar(Math.cos(e) * Math.cos(a))
        .addScaledVector(aside, Math.cos(e) * Math.sin(a)).addScaledVector(upward, Math.sin(e));
      const found = fit(toward), distance = found.distance / (zoom || 1);
      down = found.down;
      update_size();
      target.copy(bounds.centre);
      camera.position.copy(bounds.centre).addScaledVector(toward, distance);
      camera.lookAt(target);
      camera.updateMatrixWorld();
    },
    resize: update_size,  // to the size of the picture; the camera stays where it is
    default_view: default_view
  };
})(springnet);
