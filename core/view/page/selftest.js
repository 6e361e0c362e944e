// With #selftest=1 the page operates its own controls as a user would, and appends the results to itself as JSON.
(function (s) {
  s.selftest = function (scene, player) {
    const run = s.run, last = run.frames - 1, scrub = document.getElementById("scrub");
    function node_positions() { return Array.from(run.positions.row(player.frame)); }
    function scrub_to(frame) {
      scrub.value = frame;
      scrub.dispatchEvent(new Event("input", { bubbles: true }));
      return { frame: player.frame, time: run.times[player.frame], clock: document.getElementById("clock").textContent,
               pixels: scene.pixels_drawn(), places: node_positions() };
    }
    function press(name) { window.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true })); return player.frame; }
    // How many pixels a switch changes.
    function toggled(id) {
      const box = document.getElementById(id), before = scene.pixels();
      box.click();
      const after = scene.pixels();
      box.click();
      return differences(before, after);
    }
    // The farthest node from the centre of pictures of other sizes, over all records: the edges are at 1.
    function resized() {
      const sizes = [[320, 560], [560, 160], [240, 240]], point = new THREE.Vector3(), camera = s.camera.camera;
      const found = sizes.map(function (size) {
        view.style.cssText = "flex: none; width: " + size[0] + "px; height: " + size[1] + "px";
        s.resize();
        let max = 0;
        for (let k = 0; k < run.positions.numbers; k += 3) {
          point.set(run.positions.at(k), run.positions.at(k + 1), run.positions.at(k + 2)).project(camera);
          max = Math.max(max, Math.abs(point.x), Math.abs(point.y));
        }
        return max;
      });
      view.style.cssText = "";
      s.resize();
      return found;
    }
    // How many positions of nodes are covered by time and legend.
    function covered() {
      const origin = view.getBoundingClientRect(), point = new THREE.Vector3();
      const words = ["clock", "legend"].map(function (id) { return document.getElementById(id).getBoundingClientRect(); });
      let found = 0;
      for (let k = 0; k < run.positions.numbers; k += 3) {
        point.set(run.positions.at(k), run.positions.at(k + 1), run.positions.at(k + 2)).project(s.camera.camera);
        const x = origin.left + 0.5 * (1 + point.x) * origin.width, y = origin.top + 0.5 * (1 - point.y) * origin.height;
        if (words.some(function (each) { return x > each.left && x < each.right && y > each.top && y < each.bottom; })) ++found;
      }
      return found;
    }
    // Which parts of the page lie outside the window, and how large its parts are.
    function layout() {
      const width = document.documentElement.clientWidth;
      const outside = Array.from(document.body.querySelectorAll("*")).filter(function (part) {
        const place = part.getBoundingClientRect();
        return place.width > 0 && !part.closest(".plot-area") && (place.left < -0.5 || place.right > width + 0.5);
      });
      const legend = document.getElementById("legend").getBoundingClientRect(), picture = view.getBoundingClientRect();
      return { legend_over_picture: legend.top < picture.bottom - 0.5, window: width, scroll_width: document.documentElement.scrollWidth, view: view.clientWidth, height: view.clientHeight,
               outside: outside.map(function (part) { return part.id || part.className || part.tagName; }),
               plots: Array.from(document.querySelectorAll(".plot-area")).map(function (area) { return area.clientWidth; }) };
    }
    function texts(selector) {
      return Array.from(document.querySelectorAll(selector)).map(function (each) { return each.textContent; });
    }
    function curves() {
      return Array.from(document.querySelectorAll(".plot")).map(function (plot, which) {
        const head = plot.querySelector(".plot-head"), graph = s.graphs[which];
        let gaps = 0;  // after the first record, which has no step before it
        for (let k = 1; k < graph.numRows(); ++k) if (graph.getValue(k, 1) === null) ++gaps;
        return { title: head.firstChild.textContent, gaps: gaps, cut: head.scrollHeight - head.clientHeight,
                 values: Array.from(head.querySelectorAll("span")).map(function (each) { return each.textContent; }),
                 ticks: Array.from(plot.querySelectorAll(".dygraph-axis-label-y")).map(function (each) { return each.textContent; }) };
      });
    }
    function coloured(quantity) {
      const select = document.getElementById("colour"), before = scene.pixels();
      select.value = quantity;
      select.dispatchEvent(new Event("change", { bubbles: true }));
      const after = scene.pixels();
      const found = { option: select.selectedOptions[0].textContent, legend: document.getElementById("legend").textContent, changed: differences(before, after),
                      bar: document.getElementById("legend-bar").offsetHeight };
      select.value = "tension";
      select.dispatchEvent(new Event("change", { bubbles: true }));
      return found;
    }
    // What is painted: colours as they are drawn, springs and nodes in their order; the motions in three records; lines
    // about the first spring and node.
    function learned() {
      const select = document.getElementById("colour"), first = select.value, found = { first: first, paints: {} };
      function choose(name) { select.value = name; select.dispatchEvent(new Event("change", { bubbles: true })); }
      Array.from(select.options).filter(function (each) { return each.value.startsWith("learned"); }).forEach(function (option) {
        choose(option.value);
        const springs = scene.springs.mesh.geometry, open = scene.learned.open.mesh.geometry;
        found.paints[option.textContent] = {
          springs: Array.from(springs.attributes.tint.array.slice(0, 3 * springs.maxInstancedCount)),
          open: open.maxInstancedCount, nodes: Array.from(scene.dots.tints), elements: Array.from(scene.learned.middles.tints),
          legend: document.getElementById("legend").textContent,
          ticks: texts("#legend-ticks span"), bar: document.getElementById("legend-bar").offsetHeight };
      });
      choose(first);
      found.records = [0, last >> 1, last].map(function (frame) {
        const seen = run.observed(frame);
        return { time: run.times[frame], learned: Array.from(run.positions.row(frame)), start: Array.from(run.start_positions.row(frame)),
                 nodes: Array.from(seen.nodes), observed: Array.from(seen.points), kinds: Array.from(seen.kinds),
                 arrows: ["velocity", "force"].map(function (what) {
                   return s.observed_arrows(what, frame, run.positions.row(frame)).map(function (each) {
                     return { place: each.place.toArray(), direction: each.direction.toArray(), share: each.share, colour: each.colour };
                   });
                 }) };
      });
      found.motions = s.motions;
      found.experiments = Array.from(document.querySelectorAll("#experiment option")).map(function (each) { return each.textContent; });
      player.go(last);
      found.toggled = ["show-learned", "show-start", "show-observed"].map(toggled);
      found.toggled_of = {};
      ["held_out", "velocities", "reactions"].forEach(function (what) {
        if (document.getElementById("show-" + what).parentElement.style.display !== "none") found.toggled_of[what] = toggled("show-" + what);
      });
      if (run.springs > 0) found.spring = s.numbers_of({ spring: 0 }, last).concat(s.numbers_of({ spring: run.springs - 1 }, last));
      found.node = s.numbers_of({ node: run.nodes - 1 }, last);
      if (run.elements > 0) found.element = s.numbers_of({ element: 0 }, last);
      found.below = document.querySelectorAll("#figures svg .curve, #figures svg circle").length;
      return found;
    }
    // Whether a click in the middle of a broken spring that is too long to be drawn picks it.
    function picks_hidden_spring() {
      if (run.removals.size === 0) return null;
      const k = run.removals.keys().next().value, rest = run.rest_lengths[k], places = run.positions.row(player.frame);
      const a = 3 * run.ends[2 * k], b = 3 * run.ends[2 * k + 1];
      const middle = new THREE.Vector3().fromArray(places, a).add(new THREE.Vector3().fromArray(places, b)).multiplyScalar(0.5)
        .project(s.camera.camera);
      run.rest_lengths[k] = 1e-3 * rest;
      const found = s.pick_at(player.frame, 0.5 * (1 + middle.x) * view.clientWidth, 0.5 * (1 - middle.y) * view.clientHeight);
      run.rest_lengths[k] = rest;
      return Boolean(found) && found.spring === k;
    }
    function numbers_shown() {
      const all = { node: s.numbers_of({ node: 0 }, last), last_node: s.numbers_of({ node: run.nodes - 1 }, last) };
      if (run.springs > 0) all.spring = s.numbers_of({ spring: run.springs >> 1 }, last);
      if (run.rigids.length > 0) all.rigid = s.numbers_of({ rigid: 0 }, last);
      Object.keys(all).forEach(function (name) { all[name] = Object.fromEntries(all[name]); });
      return all;
    }
    // Effect of the largest displacement factor: the factors offered, the distance of drawn from true positions, the label,
    // the nodes that a click finds where they are drawn, whether values stay, the farthest node from the centre.
    function exaggerated() {
      const select = document.getElementById("displacement"), factors = s.exaggerations.slice();
      if (factors.length < 2) return { factors: factors };
      const before = JSON.stringify(numbers_shown()), pixels = scene.pixels(), frame = player.frame, place = view.getBoundingClientRect();
      function set(factor) { select.value = factor; select.dispatchEvent(new Event("change", { bubbles: true })); }
      set(factors[factors.length - 1]);
      const drawn = Array.from(s.drawn_positions(frame)), real = run.positions.row(frame), start = Array.from(run.positions.row(0)), found = { factors: factors };
      found.error = drawn.reduce(function (max, value, k) {
        return Math.max(max, Math.abs(value - start[k] - s.exaggeration * (run.positions.row(frame)[k] - start[k])));
      }, 0);
      found.moved = drawn.reduce(function (max, value, k) { return Math.max(max, Math.abs(value - real[k])); }, 0);
      found.note = document.getElementById("exaggerated").textContent;
      found.changed = differences(pixels, scene.pixels());
      found.values_unchanged = JSON.stringify(numbers_shown()) === before;
      found.picked = 0;
      found.farthest = 0;
      const points = Array.from({ length: run.nodes }, function (_, k) { return new THREE.Vector3().fromArray(drawn, 3 * k).project(s.camera.camera); });
      points.forEach(function (point) {
        found.farthest = Math.max(found.farthest, Math.abs(point.x), Math.abs(point.y));
        const picked = s.pick_at(frame, 0.5 * (1 + point.x) * place.width, 0.5 * (1 - point.y) * place.height);
        if (picked && picked.node !== undefined) ++found.picked;
      });
      set(1);
      found.restored = document.getElementById("exaggerated").hidden && s.drawn_positions(frame).every(function (value, k) { return value === real[k]; });
      return found;
    }
    // Arrows of loads in a frame, as resultants and at nodes: number, the longest relative to the network, legend.
    function arrows() {
      const box = document.getElementById("arrows-at-nodes"), size = s.camera.nodes_box.getSize(new THREE.Vector3()).length();
      function look() {
        const mode = s.shown.arrows, length = s.arrow_length(mode, s.camera.longest_arrow);
        const all = s.arrows(mode, player.frame, s.drawn_positions(player.frame)).filter(Boolean);
        return { mode: mode, count: all.length, places: all.map(function (each) { return each.place.toArray(); }),
                 longest: all.reduce(function (max, each) { return Math.max(max, each.share * length); }, 0) / size,
                 legend: document.getElementById("legend-arrow").textContent, pixels: toggled("show-forces") };
      }
      const found = [look()];
      if (s.arrow_modes.differ) { box.click(); found.push(look()); box.click(); }
      return found;
    }
    // Arrows between bodies in a frame: each as it is drawn, and their places with displacements five times as large.
    function touches() {
      const frame = player.frame, size = s.camera.nodes_box.getSize(new THREE.Vector3()).length(), length = s.touch_arrow_length(s.camera.longest_arrow);
      function all() { return s.touch_arrows(frame, s.drawn_positions(frame)); }
      let largest_share = 0;
      run.times.forEach(function (_, k) {
        s.touch_arrows(k, s.drawn_positions(k)).forEach(function (each) { largest_share = Math.max(largest_share, each.share); });
      });
      const found = { most: s.touches.most, count_at_start: s.touch_arrows(0, s.drawn_positions(0)).length, largest_share: largest_share,
                      arrows: all().map(function (each) { return { place: each.place.toArray(), direction: each.direction.toArray(), share: each.share }; }),
                      longest: length / size, legend: document.getElementById("legend-touch").textContent,
                      pixels: toggled("show-touches") };
      s.exaggeration = 5;
      found.exaggerated = all().map(function (each) { return each.place.toArray(); });
      s.exaggeration = 1;
      return found;
    }
    function banner() {
      const part = document.getElementById("banner");
      return part.hidden ? null : { kind: part.className, text: part.textContent, height: part.offsetHeight };
    }
    function differences(before, after) {
      let changed = 0;
      for (let k = 0; k < before.length; ++k) if (before[k] !== after[k]) ++changed;
      return changed;
    }
    const view = document.getElementById("view");
    const result = { frames: run.frames, has_webgl: scene.has_webgl, stops: [0, last >> 1, last].map(scrub_to) };
    result.layout = layout();
    result.banner = banner();
    result.facts = document.getElementById("facts").textContent;
    result.key = document.getElementById("key").textContent;
    result.curves = curves();
    result.covered = covered();
    result.resized = resized();
    result.numbers = numbers_shown();
    if (run.is_learned) result.learned = learned();
    result.speed = coloured("speed");
    result.states = run.about.states.map(function (_, k) { return coloured("state" + k); });
    result.state_values = Array.from(run.materials, function (_, k) {
      return run.about.states.map(function (_, which) { return run.state(last, k, which); });
    });
    if (run.has_contact) result.contact = coloured("contact");
    result.stretches_at_start = Array.from(run.rest_lengths, function (_, k) { return Object.fromEntries(s.numbers_of({ spring: k }, 0)).stretch; });
    result.exaggerated = exaggerated();
    player.go(last >> 1);
    result.arrows = arrows();
    player.go(last);
    result.touch_control = document.getElementById("show-touches").parentElement.style.display !== "none";
    if (s.touches.most > 0) result.touches = touches();
    result.remark = texts(".plot-head small");
    result.picks_hidden_spring = picks_hidden_spring();
    const place = view.getBoundingClientRect();
    // Events as a mouse causes them: press and release on the picture; drag; click on a curve.
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
    const on_slider = new KeyboardEvent("keydown", { key: "ArrowLeft", bubbles: true, cancelable: true });
    document.getElementById("opacity").dispatchEvent(on_slider);
    result.slider_keeps_arrow_keys = player.frame === last && !on_slider.defaultPrevented;
    result.keys = [press("Home"), press("ArrowRight"), press("End"), press("ArrowLeft")];
    result.toggled = { springs: toggled("show-springs"), broken: (player.go(last), toggled("show-broken")),
                       nodes: toggled("show-nodes"), faces: toggled("show-faces"), instruments: toggled("show-instruments"),
                       forces: (player.go(last >> 1), toggled("show-forces")) };
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
    result.notes = texts("#notes li");
    result.legend = document.getElementById("legend").textContent;
    player.go(0);
    player.toggle();
    let waited = 0;
    const timer = setInterval(function () {
      // Reading the picture takes real time, which the browser's virtual clock does not count.
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
