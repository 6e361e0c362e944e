// Puts the parts together.
(function (s) {
  const view = document.getElementById("view"), address = s.address;
  document.body.classList.toggle("bare", address.bare);
  document.body.classList.toggle("no-labels", !address.labels);

  const scene = new s.Scene();
  s.picked = null;
  function show(frame) {
    scene.show(frame);
    s.labels.clock(frame);
    document.getElementById("scrub").value = frame;
    if (s.show_cursors) s.show_cursors(frame);
    s.show_picked(frame);
  }
  const player = new s.Player(show);
  function refresh() { show(player.frame); }

  if (!scene.works) {
    const message = document.getElementById("message");
    message.hidden = false;
    message.textContent = "This browser draws nothing in three dimensions here: WebGL is missing or switched off. The " +
      "curves below are complete. To see the network, switch WebGL (hardware acceleration) on, or open this page in " +
      "another browser.";
  }

  const controls = new THREE.OrbitControls(s.camera.camera, view);
  controls.enableKeys = false;  // the arrows step through the records
  controls.rotateSpeed = 0.7;
  let looking = false, own = false;  // own: the eye is where the reader moved it
  function eye_moved() {
    if (!looking) own = true;
    s.camera.target.copy(controls.target);
    scene.draw();
    s.labels.eye(scene.cell);
  }
  function look(azimuth, elevation, zoom) {
    looking = true;
    s.camera.look(azimuth, elevation, zoom);
    controls.target.copy(s.camera.target);
    controls.update();
    s.camera.camera.updateMatrixWorld();
    eye_moved();
    looking = false;
    own = false;
  }
  const usual = s.camera.usual;
  function reset() {
    look(address.azimuth === null ? usual.azimuth : address.azimuth,
         address.elevation === null ? usual.elevation : address.elevation, address.zoom);
  }
  controls.addEventListener("change", eye_moved);

  s.click = function (x, y) {
    s.picked = s.pick_at(player.frame, x, y);
    refresh();
    return s.picked;
  };
  let pressed = null;
  view.addEventListener("pointerdown", function (event) { pressed = [event.clientX, event.clientY]; });
  view.addEventListener("pointerup", function (event) {
    if (!pressed || event.button !== 0 || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
    const place = view.getBoundingClientRect();
    s.click(event.clientX - place.left, event.clientY - place.top);
  });
  // A hand where a click would pick something; looked for once a picture at most.
  let hover = null;
  view.addEventListener("pointermove", function (event) {
    if (event.buttons || s.run.springs > 50000 || player.playing) return;
    if (!hover) {
      requestAnimationFrame(function () {
        const place = view.getBoundingClientRect(), found = s.pick_at(player.frame, hover[0] - place.left, hover[1] - place.top);
        view.style.cursor = found ? "pointer" : "grab";
        hover = null;
      });
    }
    hover = [event.clientX, event.clientY];
  });

  // What is drawn of the motion is larger or smaller than it was.
  function find_motion() {
    s.camera.find_motion();
    if (!own) reset();
    refresh();
  }
  s.make_panel(scene, player, refresh, find_motion);
  scene.opacity(address.opacity);
  document.getElementById("opacity").value = address.opacity;
  if (!address.bare) s.make_plots(player);
  s.make_keys(player, reset);
  s.labels.legend();
  s.labels.exaggeration();
  if (s.exaggeration !== 1 || s.shown.arrows !== "resultants") s.camera.find_motion();
  // In another size the whole motion is in view again, unless the reader has chosen what is.
  s.resize = function () {
    scene.resize();
    if (own) s.labels.eye(scene.cell); else reset();
    s.show_marks();
    s.resize_plots();
    refresh();
  };
  scene.resize();
  s.labels.clock(0);
  reset();
  s.show_marks();
  if (address.time === null) player.go(0); else player.go_to_time(address.time);
  new ResizeObserver(s.resize).observe(view);
  if (address.selftest) s.selftest(scene, player);
  else if (address.play && s.run.frames > 1) player.toggle();
  s.player = player;
  s.scene = scene;
})(springnet);
