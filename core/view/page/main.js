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

  if (!scene.has_webgl) {
    const message = document.getElementById("message");
    message.hidden = false;
    message.textContent = "This browser cannot draw the network: WebGL is missing or disabled. The curves below are " +
      "complete. To see the network, enable WebGL (hardware acceleration), or open this page in another browser.";
  }

  const controls = new THREE.OrbitControls(s.camera.camera, view);
  controls.enableKeys = false;  // the arrows step through the records
  controls.rotateSpeed = 0.7;
  let positioning = false, user_view = false;  // user_view: the user has moved the camera
  function camera_moved() {
    if (!positioning) user_view = true;
    s.camera.target.copy(controls.target);
    scene.draw();
    s.labels.camera(scene.cell);
  }
  function look(azimuth, elevation, zoom) {
    positioning = true;
    s.camera.look(azimuth, elevation, zoom);
    controls.target.copy(s.camera.target);
    controls.update();
    s.camera.camera.updateMatrixWorld();
    camera_moved();
    positioning = false;
    user_view = false;
  }
  const default_view = s.camera.default_view;
  function reset() {
    look(address.azimuth === null ? default_view.azimuth : address.azimuth,
         address.elevation === null ? default_view.elevation : address.elevation, address.zoom);
  }
  controls.addEventListener("change", camera_moved);

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
  // A pointing hand where a click would pick something; searched for at most once per picture.
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

  // Call it when the drawn motion becomes larger or smaller.
  function refit() {
    s.camera.update_bounds();
    if (!user_view) reset();
    refresh();
  }
  s.make_panel(scene, player, refresh, refit);
  scene.opacity(address.opacity);
  document.getElementById("opacity").value = address.opacity;
  if (!address.bare) s.make_plots(player);
  s.make_keys(player, reset);
  s.labels.legend();
  s.labels.exaggeration();
  if (s.exaggeration !== 1 || s.shown.arrows !== "resultants") s.camera.update_bounds();
  // In a window of another size the whole motion is in view again, unless the user has moved the camera.
  s.resize = function () {
    scene.resize();
    if (user_view) s.labels.camera(scene.cell); else reset();
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
