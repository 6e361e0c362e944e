// With #selftest=1 the page tries itself as a user would, and writes what it found as JSON into its end.
(function (s) {
  s.selftest = function (scene, player) {
    const run = s.run, last = run.frames - 1, scrub = document.getElementById("scrub");
    function node_places() { return Array.from(run.positions.row(player.frame)); }
    function scrub_to(frame) {
      scrub.value = frame;
      scrub.dispatchEvent(new Event("input", { bubbles: true }));
      return { frame: player.frame, time: run.times[player.frame], clock: document.getElementById("clock").textContent,
               pixels: scene.pixels_drawn(), places: node_places() };
    }
    function key(name) { window.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true })); return player.frame; }
    // How many pixels a switch changes.
    function toggled(id) {
      const box = document.getElementById(id), before = scene.pixels();
      box.click();
      const after = scene.pixels();
      box.click();
      let changed = 0;
      for (let k = 0; k < before.length; ++k) if (before[k] !== after[k]) ++changed;
      return changed;
    }
    const result = { frames: run.frames, works: scene.works, stops: [0, last >> 1, last].map(scrub_to) };
    // As a mouse does it: press and let go on the picture; drag; click on a curve.
    const view = document.getElementById("view"), place = view.getBoundingClientRect();
    function mouse(target, name, x, y) {
      const Kind = name.startsWith("pointer") ? PointerEvent : MouseEvent;
      target.dispatchEvent(new Kind(name, { clientX: x, clientY: y, button: 0, buttons: 1, bubbles: true, cancelable: true, view: window, detail: 1 }));
    }
    const screen = new THREE.Vector3().fromArray(result.stops[2].places).project(s.camera.camera);
    const x = place.left + 0.5 * (1 + screen.x) * place.width, y = place.top + 0.5 * (1 - screen.y) * place.height;
    mouse(view, "pointerdown", x, y);
    mouse(view, "pointerup", x, y);
    result.picked = s.picked;
    result.picked_text = document.getElementById("picked").textContent;
    result.keys = [key("Home"), key("ArrowRight"), key("End"), key("ArrowLeft")];
    result.toggled = { springs: toggled("show-springs"), broken: (player.go(last), toggled("show-broken")),
                       nodes: toggled("show-nodes"), faces: toggled("show-faces"), instruments: toggled("show-instruments") };
    const eye = s.camera.camera.position.clone();
    mouse(view, "mousedown", x, y);
    mouse(document, "mousemove", x + 60, y);
    mouse(document, "mouseup", x + 60, y);
    result.eye_moved = eye.distanceTo(s.camera.camera.position) / s.camera.radius;
    const area = document.querySelector(".plot-area"), graph = area && area.getBoundingClientRect();
    if (graph) {
      const canvas = area.querySelectorAll("canvas")[1], middle = [graph.left + 0.5 * graph.width, graph.top + 40];
      mouse(canvas, "mousemove", middle[0], middle[1]);
      mouse(canvas, "mousedown", middle[0], middle[1]);
      mouse(document, "mouseup", middle[0], middle[1]);
      result.curve_clicked = player.frame;
    }
    result.plots = document.querySelectorAll(".plot canvas").length;
    result.notes = Array.from(document.querySelectorAll("#notes li")).map(function (item) { return item.textContent; });
    result.legend = document.getElementById("legend").textContent;
    player.go(0);
    player.toggle();
    let waited = 0;
    const timer = setInterval(function () {
      // Reading the picture takes the time of a clock that nothing winds on.
      if (player.frame === 0 && ++waited < 400 && (scene.pixels_drawn(), true)) return;
      clearInterval(timer);
      player.pause();
      result.played = player.frame;
      result.errors = s.errors;
      write(result);
    }, 50);
  };

  function write(result) {
    const out = document.createElement("script");
    out.type = "application/json";
    out.id = "selftest";
    out.textContent = JSON.stringify(result).replace(/</g, "\\u003c");
    document.body.append(out);
  }
})(springnet);
