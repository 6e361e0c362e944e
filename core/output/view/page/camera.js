// Where the eye is: up is against gravity, and the whole motion is in view.
(function (s) {
  const run = s.run, surfaces = run.about.surfaces;

  function box_of_motion() {
    const box = new THREE.Box3(), point = new THREE.Vector3();
    for (let k = 0; k < run.positions.numbers; k += 3) {
      box.expandByPoint(point.set(run.positions.at(k), run.positions.at(k + 1), run.positions.at(k + 2)));
    }
    return box;
  }
  // Pieces that fly far away would make the rest a dot: they may leave the picture.
  function without_flights(whole) {
    const start = new THREE.Box3().setFromArray(Array.from(run.positions.row(0)));
    const size = start.getSize(new THREE.Vector3()).length();
    if (!(size > 0) || whole.getSize(new THREE.Vector3()).length() < 3.5 * size) return whole;
    return whole.intersect(start.expandByScalar(0.8 * size));
  }
  const motion = box_of_motion();
  if (motion.isEmpty()) motion.expandByPoint(new THREE.Vector3());
  const nodes_box = without_flights(motion);

  // Instruments near the nodes are in view too, as far as they are near.
  const balls = [];
  function add_instruments(box) {
    const margin = 0.4 * Math.max(nodes_box.getSize(new THREE.Vector3()).length(), 1e-9);
    const near = nodes_box.clone().expandByScalar(margin);
    surfaces.forEach(function (surface, k) {
      if (surface.kind === "plane") return;
      const reach = new THREE.Vector3().setScalar(surface.radius);
      const to = new THREE.Vector3().fromArray(surface.to).sub(new THREE.Vector3().fromArray(surface.point));
      for (let frame = 0; frame < run.frames; ++frame) {
        const first = new THREE.Vector3().fromArray(run.surface(frame, k));
        [first, first.clone().add(to)].forEach(function (end) {
          const ball = new THREE.Box3(end.clone().sub(reach), end.clone().add(reach)).intersect(near);
          if (ball.isEmpty()) return;
          box.union(ball);
          balls.push(ball);
        });
      }
    });
    return box;
  }
  const box = add_instruments(nodes_box.clone());
  const centre = box.getCenter(new THREE.Vector3());
  let radius = 0.5 * box.getSize(new THREE.Vector3()).length();
  if (!(radius > 0)) radius = 1;

  function axis(k) { return new THREE.Vector3().setComponent(k, 1); }
  function flat_axis() {
    const size = nodes_box.getSize(new THREE.Vector3()).toArray();
    const most = Math.max.apply(null, size);
    const k = size.indexOf(Math.min.apply(null, size));
    return most > 0 && size[k] < 1e-3 * most && size.filter(function (each) { return each < 1e-3 * most; }).length === 1 ? k : -1;
  }
  const flat = flat_axis();
  const gravity = new THREE.Vector3().fromArray(run.about.gravity);
  let up = flat === 2 ? 1 : 2;
  let sign = 1;
  if (gravity.length() > 0) {
    const pull = gravity.toArray().map(Math.abs);
    up = pull.indexOf(Math.max.apply(null, pull));
    sign = gravity.getComponent(up) > 0 ? -1 : 1;
  }
  const upward = axis(up).multiplyScalar(sign);
  // Azimuth is counted about the up axis from `ahead`.
  const ahead = axis((up + 1) % 3), aside = new THREE.Vector3().crossVectors(upward, ahead);

  const usual = { azimuth: -62, elevation: 18 };
  if (flat >= 0 && flat !== up) {
    usual.azimuth = flat === (up + 1) % 3 ? 0 : sign * -90;
    usual.elevation = 0;
    if (up === 1 && flat === 2) usual.azimuth = 0;
  }

  const camera = new THREE.PerspectiveCamera(32, 1, radius / 100, radius * 60);
  camera.up.copy(upward);
  const target = new THREE.Vector3();

  // Places that shall be in view: some of all nodes and frames, and the ends of instruments' boxes.
  const seen = [];
  const stride = 3 * Math.max(1, Math.floor(run.positions.numbers / 3 / 20000));
  for (let k = 0; k < run.positions.numbers; k += stride) {
    const place = new THREE.Vector3(run.positions.at(k), run.positions.at(k + 1), run.positions.at(k + 2));
    if (box.containsPoint(place)) seen.push(place.sub(centre));
  }
  balls.forEach(function (ball) {
    [ball.min, ball.max].forEach(function (corner) { seen.push(corner.clone().sub(centre)); });
  });

  // From where all of them just fit, with a margin.
  function fitting_distance(toward) {
    const right = new THREE.Vector3().crossVectors(upward, toward).normalize();
    const over = new THREE.Vector3().crossVectors(toward, right);
    const slope = 0.86 * Math.tan(camera.fov * Math.PI / 360);
    let distance = 1e-3 * radius;
    seen.forEach(function (place) {
      const wide = Math.max(Math.abs(place.dot(over)), Math.abs(place.dot(right)) / camera.aspect);
      distance = Math.max(distance, place.dot(toward) + wide / slope);
    });
    return distance;
  }

  s.camera = {
    depth: new THREE.Vector2(0, 1),  // distances from the eye between which the motion lies; kept by measure()
    measure: function () {
      const distance = camera.position.distanceTo(centre);
      this.depth.set(Math.max(0, distance - 0.8 * radius), distance + 0.8 * radius);
    },
    camera: camera, target: target, centre: centre, radius: radius, upward: upward, flat: flat, nodes_box: nodes_box,
    // Degrees; zoom 1 shows the whole motion.
    look: function (azimuth, elevation, zoom) {
      const a = azimuth * Math.PI / 180, e = Math.min(89.9, Math.max(-89.9, elevation)) * Math.PI / 180;
      const toward = ahead.clone().multiplyScalar(Math.cos(e) * Math.cos(a))
        .addScaledVector(aside, Math.cos(e) * Math.sin(a)).addScaledVector(upward, Math.sin(e));
      const distance = fitting_distance(toward) / (zoom || 1);
      target.copy(centre);
      camera.position.copy(centre).addScaledVector(toward, distance);
      camera.lookAt(target);
      camera.updateMatrixWorld();
    },
    usual: usual
  };
})(springnet);
