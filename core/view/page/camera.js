// Where the eye is: up is against gravity, and the whole motion is in view.
(function (s) {
  const run = s.run, surfaces = run.about.surfaces;

  function diagonal(box) { return box.getSize(new THREE.Vector3()).length(); }
  function box_of_motion() {
    const box = new THREE.Box3(), point = new THREE.Vector3();
    for (let k = 0; k < run.positions.numbers; k += 3) {
      box.expandByPoint(point.set(s.place_at(k), s.place_at(k + 1), s.place_at(k + 2)));
    }
    if (box.isEmpty()) box.expandByPoint(new THREE.Vector3());
    return box;
  }
  // Pieces that fly far away would make the rest a dot: they may leave the picture.
  function without_flights(whole) {
    const start = new THREE.Box3().setFromArray(Array.from(run.positions.row(0)));
    const size = diagonal(start);
    if (!(size > 0) || diagonal(whole) < 3.5 * size) return whole;
    return whole.intersect(start.expandByScalar(0.8 * size));
  }
  // Instruments near the nodes are in view too, as far as they are near: boxes about their ends.
  function near_instruments(nodes_box) {
    const near = nodes_box.clone().expandByScalar(0.4 * Math.max(diagonal(nodes_box), 1e-9)), balls = [];
    surfaces.forEach(function (surface, k) {
      if (surface.kind === "plane") return;
      const box = surface.kind === "box";
      const reach = new THREE.Vector3().setScalar(box ? 0.5 * new THREE.Vector3().fromArray(surface.size).length() : surface.radius);
      const to = new THREE.Vector3();
      if (!box) to.fromArray(surface.to).sub(new THREE.Vector3().fromArray(surface.point));
      for (let frame = 0; frame < run.frames; ++frame) {
        const pose = run.surface(frame, k), first = new THREE.Vector3().fromArray(pose);
        const turned = new THREE.Quaternion().fromArray(pose, 3);
        [first, first.clone().add(to.clone().applyQuaternion(turned))].forEach(function (end) {
          const ball = new THREE.Box3(end.clone().sub(reach), end.clone().add(reach)).intersect(near);
          if (!ball.isEmpty()) balls.push(ball);
        });
      }
    });
    return balls;
  }
  // So are the arrows of forces, while they act: their ends.
  function ends_of_arrows(nodes_box, longest) {
    const ends = [], way = s.shown.arrows, length = s.arrow_length(way, longest);
    const stride = Math.max(1, Math.ceil(run.frames * run.arrow_nodes.length / 5000));
    for (let frame = 0; run.arrow_nodes.length > 0 && frame < run.frames; frame += stride) {
      s.arrows(way, frame, s.places(frame)).forEach(function (arrow) {
        if (!arrow || !nodes_box.containsPoint(arrow.place)) return;
        const start = s.arrow_start(arrow, length);
        ends.push(start, start.clone().addScaledVector(arrow.direction, arrow.share * length));
      });
    }
    return ends;
  }

  function common_divisor(a, b) { return b === 0 ? a : common_divisor(b, a % b); }

  // What shall be in view: its box, and some of all nodes and frames with the corners of the boxes above, from its centre.
  function find_motion() {
    const nodes_box = without_flights(box_of_motion()), longest = 0.16 * diagonal(nodes_box) || 0.3, box = nodes_box.clone();
    const balls = near_instruments(nodes_box), ends = ends_of_arrows(nodes_box, longest), seen = [];
    balls.forEach(function (ball) { box.union(ball); });
    ends.forEach(function (end) { box.expandByPoint(end); });
    const centre = box.getCenter(new THREE.Vector3());
    // One in so many, which has no divisor in common with the number of nodes: each node comes in turn.
    let stride = Math.max(1, Math.floor(run.positions.numbers / 3 / 20000));
    while (common_divisor(stride, run.nodes) > 1) ++stride;
    for (let k = 0; k < run.positions.numbers; k += 3 * stride) {
      const place = new THREE.Vector3(s.place_at(k), s.place_at(k + 1), s.place_at(k + 2));
      if (box.containsPoint(place)) seen.push(place.sub(centre));
    }
    balls.forEach(function (ball) { seen.push(ball.min.clone().sub(centre), ball.max.clone().sub(centre)); });
    ends.forEach(function (end) { seen.push(end.clone().sub(centre)); });
    return { nodes_box: nodes_box, longest_arrow: longest, centre: centre, radius: 0.5 * diagonal(box) || 1, seen: seen };
  }
  let motion = find_motion();
  const nodes_box = motion.nodes_box;

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

  const camera = new THREE.PerspectiveCamera(32, 1, motion.radius / 100, motion.radius * 60);
  camera.up.copy(upward);
  const target = new THREE.Vector3();

  // What lies on the picture, [left, top, right, bottom] in pixels: time and legend above, scale and axes below. The
  // words of the scale depend on the distance: room for usual ones.
  function laid_over(width, height) {
    function place_of(id) {
      const part = document.getElementById(id);
      return [part.offsetLeft, part.offsetTop, part.offsetLeft + part.offsetWidth, part.offsetTop + part.offsetHeight];
    }
    if (document.body.classList.contains("no-labels")) return { above: [], below: [] };
    const scale = surfaces.some(function (each) { return each.kind === "plane"; }) ? 250 : 170;
    return { above: [place_of("clock"), place_of("legend")].filter(function (each) { return each[3] > each[1] && each[1] < height; }),
             below: [[0, height - 48, Math.min(scale, width - 100), height], [width - 96, height - 96, width, height]] };
  }

  // From where all of them just fit, with a margin; and by how many pixels the picture is moved down for that. Strips
  // above and below are kept free as far as something would lie under the words there otherwise.
  function fit(toward) {
    const view = document.getElementById("view"), width = Math.max(1, view.clientWidth), height = Math.max(1, view.clientHeight);
    const right = new THREE.Vector3().crossVectors(upward, toward).normalize();
    const over = new THREE.Vector3().crossVectors(toward, right);
    const half = Math.tan(camera.fov * Math.PI / 360), aspect = width / height;
    const places = motion.seen.map(function (place) { return [place.dot(right), place.dot(over), place.dot(toward)]; });
    const laid = laid_over(width, height), all = laid.above.concat(laid.below);
    const top = Math.min(0.3 * height, laid.above.reduce(function (most, each) { return Math.max(most, each[3]); }, 0));
    const bottom = Math.min(0.15 * height, laid.below.reduce(function (most, each) { return Math.max(most, height - each[1]); }, 0));

    function with_strips(share) {
      const slope = half * (0.86 + 0.1 * share) * (1 - share * (top + bottom) / height);
      let distance = 1e-3 * motion.radius;
      places.forEach(function (place) {
        const reach = Math.max(Math.abs(place[1]) / slope, Math.abs(place[0]) / (0.86 * half * aspect));
        distance = Math.max(distance, place[2] + reach);
      });
      return { distance: distance, down: share * (top - bottom) / 2 };
    }
    function under_words(found) {
      return places.some(function (place) {
        const depth = half * (found.distance - place[2]);
        const x = width / 2 * (1 + place[0] / (depth * aspect)), y = height / 2 * (1 - place[1] / depth) + found.down;
        return all.some(function (each) { return x > each[0] && x < each[2] && y > each[1] && y < each[3]; });
      });
    }
    let found = with_strips(0);
    for (let k = 1; k <= 6 && all.length > 0 && under_words(found); ++k) found = with_strips(k / 6);
    return found;
  }
  let down = 0;
  function take_size() {
    const view = document.getElementById("view"), width = Math.max(1, view.clientWidth), height = Math.max(1, view.clientHeight);
    camera.setViewOffset(width, height, 0, -down, width, height);  // sets the aspect too
  }

  s.camera = {
    depth: new THREE.Vector2(0, 1),  // distances from the eye between which the motion lies; kept by measure()
    measure: function () {
      const distance = camera.position.distanceTo(motion.centre);
      this.depth.set(Math.max(0, distance - 0.8 * motion.radius), distance + 0.8 * motion.radius);
    },
    camera: camera, target: target, longest_arrow: motion.longest_arrow,
    centre: motion.centre, radius: motion.radius, upward: upward, flat: flat, nodes_box: nodes_box,
    // After what is drawn of the motion has changed; a call of look() brings it into view.
    find_motion: function () {
      motion = find_motion();
      camera.far = Math.max(camera.far, 60 * motion.radius);
      camera.updateProjectionMatrix();
    },
    // Degrees; zoom 1 shows the whole motion.
    look: function (azimuth, elevation, zoom) {
      const a = azimuth * Math.PI / 180, e = Math.min(89.9, Math.max(-89.9, elevation)) * Math.PI / 180;
      const toward = ahead.clone().multiplyScalar(Math.cos(e) * Math.cos(a))
        .addScaledVector(aside, Math.cos(e) * Math.sin(a)).addScaledVector(upward, Math.sin(e));
      const found = fit(toward), distance = found.distance / (zoom || 1);
      down = found.down;
      take_size();
      target.copy(motion.centre);
      camera.position.copy(motion.centre).addScaledVector(toward, distance);
      camera.lookAt(target);
      camera.updateMatrixWorld();
    },
    resize: take_size,  // to that of the picture; the eye stays where it is
    usual: usual
  };
})(springnet);
