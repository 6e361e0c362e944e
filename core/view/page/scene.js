// Draws one frame: springs, nodes, faces, surfaces, loads, forces between bodies, and what is picked.
(function (s) {
  const run = s.run, colours = s.colours, count = Math.max(run.springs, run.nodes);
  const spring_width = count < 400 ? 4 : count < 800 ? 3.2 : count < 4000 ? 2.2 : count < 20000 ? 1.5 : 1;
  const dot_size = count < 800 ? 7 : count < 4000 ? 5 : count < 20000 ? 3.4 : 2.2;

  // Whether spring k is drawn in the frame. A broken one is, until its ends are far apart: lines across the whole picture
  // would hide everything else.
  s.is_drawn = function (k, frame, positions) {
    if (run.is_learned && !s.shown.learned) return false;
    if (frame < run.removal_frames[k]) return s.shown.springs;
    const a = 3 * run.ends[2 * k], b = 3 * run.ends[2 * k + 1], max_length = 3 * run.rest_lengths[k];
    return s.shown.broken && (max_length === 0 ||
      Math.hypot(positions[a] - positions[b], positions[a + 1] - positions[b + 1], positions[a + 2] - positions[b + 2]) < max_length);
  };

  function make_renderer() {
    try {
      return new THREE.WebGLRenderer({ canvas: document.getElementById("canvas"), antialias: true, alpha: true });
    } catch (failure) {
      return null;
    }
  }

  s.Scene = function () {
    const renderer = make_renderer();
    this.has_webgl = renderer !== null;
    const camera = s.camera.camera, scene = new THREE.Scene();
    const springs = new s.Segments(run.springs, { width: spring_width });
    const broken = new s.Segments(run.removals.size, { width: Math.max(1, 0.5 * spring_width), opacity: 0.45, dash: 5 });
    const rigids = new s.Segments(run.rigids.length / 2, { width: spring_width + 1.6 });
    const dots = new s.Dots(run.nodes);
    const picked_spring = new s.Segments(1, { width: spring_width + 3, above: true });
    const picked_node = new s.Dots(1, 0.72);
    const faces = new s.Faces(), surfaces = new s.Surfaces(), forces = new s.Forces(), touches = new s.Touches();
    const learned = run.is_learned ? new s.LearnedLayers(spring_width, dot_size) : null;
    const layers = [springs, broken, rigids, dots, picked_spring, picked_node].concat(learned ? learned.layers : []);
    layers.forEach(function (layer) { scene.add(layer.mesh); });
    scene.add(faces.mesh, surfaces.group, forces.group, touches.group);
    if (learned) scene.add(learned.group);
    const sky = new THREE.HemisphereLight(0xffffff, 0x9aa2ad, 0.66);
    sky.position.copy(s.camera.upward);
    scene.add(sky);
    // Attached to the camera: shines from the upper left behind it.
    const lamp = new THREE.DirectionalLight(0xffffff, 0.5);
    lamp.position.set(-0.9, 0.7, 1);
    camera.add(lamp, lamp.target);
    scene.add(camera);
    this.springs = springs;
    this.dots = dots;
    this.learned = learned;
    this.cell = surfaces.cell;
    this.opacity = faces.opacity;
    faces.opacity(0.8);

    function show_springs(frame, positions) {
      const quantity = s.shown.colour, ends = run.ends, hidden = run.is_learned && !s.shown.learned;
      const values = quantity === "tension" ? run.tensions.row(frame) : run.speeds.row(frame);
      const shown = run.quantity(quantity), paint = shown.paint, range = paint ? 0 : shown.range.shown, state = shown.of_state;
      const table = shown.symmetric ? colours.tension.table : colours.speed.table;
      springs.begin();
      broken.begin();
      if (learned) learned.open.begin();
      for (let k = 0; k < run.springs; ++k) {
        const a = ends[2 * k], b = ends[2 * k + 1];
        if (!s.is_drawn(k, frame, positions)) continue;
        if (frame >= run.removal_frames[k]) {
          broken.add(positions, a, b, colours.plain, 0);
        } else if (paint) {
          const look = paint.of === "springs" ? paint.look(k) : -1;
          if (look >= 0) springs.add(positions, a, b, paint.table, look);
          else if (look === -1) springs.add(positions, a, b, colours.without, 0);
          else learned.open.add(positions, a, b, colours.open, 0);
        } else if (quantity === "contact") {
          springs.add(positions, a, b, run.in_contact(frame, a) && run.in_contact(frame, b) ? colours.contact : colours.plain, 0);
        } else {
          const value = state !== undefined ? run.state(frame, k, state) : quantity === "tension" ? values[k] : 0.5 * (values[a] + values[b]);
          if (value === null) springs.add(positions, a, b, colours.without, 0);
          else springs.add(positions, a, b, table, colours.offset(value, range, shown.symmetric));
        }
      }
      springs.end();
      broken.end();
      if (learned) learned.open.end();
      rigids.begin();
      for (let k = 0; !hidden && k < run.rigids.length; k += 2) rigids.add(positions, run.rigids[k], run.rigids[k + 1], colours.rigid, 0);
      rigids.end();
    }

    function show_nodes(frame, positions) {
      const paint = run.quantity(s.shown.colour).paint, painted = Boolean(paint) && paint.of === "nodes";
      dots.mesh.visible = (s.shown.nodes || painted) && !(run.is_learned && !s.shown.learned);
      if (!dots.mesh.visible) return;
      dots.positions.set(positions);
      const by_speed = s.shown.colour === "speed", speeds = by_speed ? run.speeds.row(frame) : null;
      for (let k = 0; k < run.nodes; ++k) {
        const touching = run.in_contact(frame, k), kind = run.kinds[k];
        let table = touching ? colours.contact : kind === 1 ? colours.fixed : kind === 2 ? colours.moved : colours.free, offset = 0;
        if (by_speed && !touching && kind === 0) {
          table = colours.speed.table;
          offset = colours.offset(speeds[k], run.speed_range.shown, false);
        }
        const look = painted ? paint.look(k) : -1;
        if (look !== -1) [table, offset] = learned.dot(paint, look);
        for (let c = 0; c < 3; ++c) dots.tints[3 * k + c] = table[offset + c];
        dots.sizes[k] = touching || kind === 2 ? 1.4 * dot_size : kind === 1 ? 1.15 * dot_size : dot_size;
        if (look !== -1) dots.sizes[k] = 1.6 * dot_size;
      }
      dots.update();
    }

    function highlight_picked(frame, positions) {
      const picked = s.picked;
      picked_spring.begin();
      if (picked && picked.node === undefined && picked.element === undefined) {
        const rigid = picked.spring === undefined, ends = rigid ? run.rigids : run.ends, k = 2 * (rigid ? picked.rigid : picked.spring);
        picked_spring.add(positions, ends[k], ends[k + 1], [250, 200, 0], 0);
      }
      picked_spring.end();
      picked_node.mesh.visible = Boolean(picked) && (picked.node !== undefined || picked.element !== undefined);
      if (!picked_node.mesh.visible) return;
      if (picked.element !== undefined) run.middle_of(picked.element, positions, picked_node.positions, 0);
      else picked_node.positions.set(positions.subarray(3 * picked.node, 3 * picked.node + 3));
      picked_node.tints.set([230, 150, 0]);
      picked_node.sizes[0] = dot_size + 11;
      picked_node.update();
    }

    this.show = function (frame) {
      const positions = s.drawn_positions(frame);
      show_springs(frame, positions);
      show_nodes(frame, positions);
      highlight_picked(frame, positions);
      if (learned) learned.show(frame, positions);
      faces.mesh.visible = s.shown.faces && faces.count > 0 && !(run.is_learned && !s.shown.learned);
      if (faces.mesh.visible) faces.show(frame, positions);
      surfaces.group.visible = s.shown.instruments;
      surfaces.show(frame);
      forces.group.visible = s.shown.forces;
      forces.show(frame, positions);
      touches.group.visible = s.shown.touches;
      touches.show(frame, positions);
      this.draw();
    };
    this.draw = function () {
      s.camera.update_depth();
      if (renderer) renderer.render(scene, camera);
    };
    this.resize = function () {
      const view = document.getElementById("view");
      const width = Math.max(1, view.clientWidth), height = Math.max(1, view.clientHeight);
      const ratio = Math.min(window.devicePixelRatio || 1, 2);
      s.camera.resize();
      const thickness = ratio * Math.min(1, Math.max(0.55, Math.min(width, height) / 520));  // finer lines and dots in small pictures
      layers.forEach(function (layer) { layer.resize(width * ratio, height * ratio, thickness); });
      if (!renderer) return;
      renderer.setPixelRatio(ratio);
      renderer.setSize(width, height, false);
    };
    // Draws, and returns the picture: one number per pixel, with the highest byte (alpha) 0 where nothing is drawn.
    this.pixels = function () {
      if (!renderer) return new Uint32Array(0);
      this.draw();
      const gl = renderer.getContext(), width = gl.drawingBufferWidth, height = gl.drawingBufferHeight;
      const pixels = new Uint8Array(4 * width * height);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      return new Uint32Array(pixels.buffer);
    };
    this.pixels_drawn = function () {
      return this.pixels().reduce(function (drawn, pixel) { return drawn + (pixel >>> 24 > 0 ? 1 : 0); }, 0);
    };
    if (renderer) renderer.setClearColor(0xffffff, 0);
  };
})(springnet);
