// Header, banner and panel: texts above and beside the picture, and the controls.
(function (s) {
  const run = s.run, about = run.about;
  function element(id) { return document.getElementById(id); }

  function count(number, what) { return number + " " + what + (number === 1 ? "" : "s"); }

  function show_header() {
    const title = about.title || "A network of springs";
    element("title").textContent = title;
    document.title = title + " – springnet";
    const facts = [count(about.nodes, "node"), count(about.springs, "spring")];
    if (about.elements > 0) facts.push(count(about.elements, "element"));
    const gap = run.frames > 1 ? (run.times[run.frames - 1] - run.times[0]) / (run.frames - 1) : about.time_step;
    facts.push("integrator " + about.integrator,
               run.internal_steps ? "records every " + s.number(gap, 3) + " s" : "time step " + s.number(about.time_step) + " s",
               count(run.frames, "record"));
    element("facts").textContent = facts.join(" · ");

    about.notes.forEach(function (text) {
      const item = document.createElement("li");
      item.textContent = text;
      element("notes").append(item);
    });
    element("notes-title").hidden = about.notes.length === 0;
  }

  // A banner above everything, if the run failed, with the reason, or ended early.
  function show_banner() {
    const last = run.times[run.frames - 1], early = last < about.duration * (1 - 1e-6), failed = about.failure !== "";
    const banner = element("banner");
    banner.hidden = !failed && !early;
    banner.className = failed ? "failed" : "stopped";
    element("banner-title").textContent = "The run " + (failed ? "failed" : "ended early,") +
      (early ? " at " + s.number(last, 5) + " s of " + s.number(about.duration, 5) + " s" : "") + (failed ? ":" : ".");
    element("banner-reason").textContent = about.failure;
  }

  function show_key() {
    const kinds = [["free", "free node", true], ["fixed", "fixed node", run.kinds.indexOf(1) >= 0],
                   ["moved", "node moved by the scene", run.kinds.indexOf(2) >= 0],
                   ["contact", "node in contact", run.has_contact]];
    const dots = kinds.filter(function (kind) { return kind[2]; }).map(function (kind) {
      return [s.colours[kind[0]], kind[1]];
    });
    const names = { cut: "springs cut", ruptured: "springs ruptured", touched: "new contacts" };
    const happened = Object.keys(names).filter(function (name) { return s.marks.some(function (m) { return m.name === name; }); });
    function add(shape, colour, text) {
      const line = document.createElement("div"), dot = document.createElement("i");
      dot.className = shape;
      dot.style.color = typeof colour === "string" ? colour : "rgb(" + colour.join(",") + ")";
      line.append(dot, text);
      element("key").append(line);
    }
    dots.forEach(function (each) { add("dot", each[0], each[1]); });
    if (run.rigids.length > 0) add("bar", s.colours.rigid, "rigid connection");
    if (run.is_learned) {
      add("bar", s.colours.start, "motion of the values at the start");
      const seen = run.observed_kinds, next_to = ", next to the time of the record";
      if (seen.position) add("ring", s.colours.observed, "observed" + next_to);
      if (seen.held_position) add("ring", s.colours.held_out, "held out" + next_to);
      if (seen.velocity) add("arrow", s.colours.velocity, "observed velocity" + seen.one_of("velocity"));
      if (seen.force) add("arrow", s.colours.reaction, "observed force that holds a node" + seen.one_of("force"));
      if (seen.held_velocity || seen.held_force) add("arrow", s.colours.held_out, "held-out velocity or force");
    }
    if (about.loads.length > 0) add("arrow", s.colours.force, "force of the scene’s loads");
    if (s.touches.most > 0) add("arrow", s.colours.touch, "force between bodies in contact, on each of them");
    happened.forEach(function (name) { add("mark", s.mark_colours[name], "timeline: " + names[name]); });
  }

  function hide_unused_controls() {
    const present = { springs: run.springs > 0, broken: run.removals.size > 0, nodes: run.nodes > 0,
                    faces: run.face_frames.length > 0, instruments: about.surfaces.length > 0,
                    forces: about.loads.length > 0, arrows: s.arrow_modes.differ, displacement: s.has_motion,
                    touches: s.touches.most > 0,
                    learned: run.is_learned };
    const seen = run.observed_kinds;
    present.observed = seen && (seen.position || seen.velocity || seen.force);
    present.held_out = seen && (seen.held_position || seen.held_velocity || seen.held_force);
    present.velocities = seen && (seen.velocity || seen.held_velocity);
    present.reactions = seen && (seen.force || seen.held_force);
    document.querySelectorAll("#panel [data-for]").forEach(function (label) {
      label.style.display = present[label.dataset.for] ? "" : "none";
    });
    if (!run.has_contact) element("colour").querySelector("[value=contact]").remove();
  }

  s.make_panel = function (scene, player, refresh, refit) {
    show_header();
    show_banner();
    show_key();
    hide_unused_controls();
    ["springs", "broken", "nodes", "faces", "instruments", "forces", "touches", "learned", "start", "observed", "held_out", "velocities", "reactions"].forEach(function (what) {
      const box = element("show-" + what);
      box.checked = s.shown[what];
      box.addEventListener("change", function () {
        s.shown[what] = box.checked;
        s.labels.legend();  // which has scales of arrows
        refresh();
      });
    });
    const experiment = element("experiment");
    element("experiment-row").hidden = s.motions.titles.length < 2;
    s.motions.titles.forEach(function (title, k) { experiment.append(new Option(k + 1 + (title ? ": " + title : ""), k + 1)); });
    experiment.value = s.motions.shown;
    experiment.addEventListener("change", function () {
      // What is shown stays, but for the time.
      const parameters = new URLSearchParams(location.hash.slice(1));
      parameters.set("experiment", experiment.value);
      parameters.delete("time");
      location.hash = parameters.toString();
      location.reload();
    });
    const arrows = element("arrows-at-nodes"), displacement = element("displacement");
    arrows.checked = s.shown.arrows === "nodes";
    arrows.addEventListener("change", function () {
      s.shown.arrows = arrows.checked ? "nodes" : "resultants";
      s.labels.legend();
      refit();
    });
    const factors = s.exaggerations.concat(s.exaggerations.includes(s.exaggeration) ? [] : s.exaggeration);
    factors.forEach(function (each) { displacement.append(new Option("× " + s.number(each), each)); });
    displacement.value = s.exaggeration;
    displacement.addEventListener("change", function () {
      s.exaggeration = Number(displacement.value);
      s.labels.exaggeration();
      refit();
    });
    about.states.forEach(function (state, k) {
      element("colour").append(new Option(state.label + (state.unit ? " (" + state.unit + ")" : ""), "state" + k));
    });
    run.learned.forEach(function (learned, k) {
      const group = document.createElement("optgroup");
      group.label = learned.name;
      learned.kinds.forEach(function (kind) {
        const name = "learned" + k + "." + kind, shown = run.quantity(name);
        group.append(new Option(shown.title + (shown.unit ? " (" + shown.unit + ")" : ""), name));
      });
      element("colour").append(group);
    });
    element("colour").value = s.shown.colour;
    element("colour").addEventListener("change", function (event) {
      s.shown.colour = event.target.value;
      s.labels.legend();
      refresh();
    });
    element("opacity").addEventListener("input", function (event) { scene.opacity(Number(event.target.value)); refresh(); });

    const scrub = element("scrub"), speed = element("speed");
    scrub.max = run.frames - 1;
    scrub.addEventListener("input", function () { player.pause(); player.go(Number(scrub.value)); });
    player.speeds.forEach(function (each) { speed.append(new Option(each + " ×", each)); });
    speed.value = player.speed;
    speed.addEventListener("change", function () { player.speed = Number(speed.value); });
    element("loop").addEventListener("change", function (event) { player.loop = event.target.checked; });
    element("play").addEventListener("click", player.toggle);
    element("back").addEventListener("click", function () { player.step(-1); });
    element("forward").addEventListener("click", function () { player.step(1); });
    player.on_change = function () { element("play").textContent = player.playing ? "pause" : "play"; };
  };

  s.make_keys = function (player, reset) {
    const actions = {
      " ": player.toggle, ArrowLeft: function (event) { player.step(event.shiftKey ? -10 : -1); },
      ArrowRight: function (event) { player.step(event.shiftKey ? 10 : 1); },
      Home: function () { player.step(-run.frames); }, End: function () { player.step(run.frames); },
      r: reset, b: function () { element("show-broken").click(); }, l: function () { element("loop").click(); }
    };
    window.addEventListener("keydown", function (event) {
      // Menus, buttons and sliders keep the keys that operate them, but for the time slider, whose arrow keys the page handles.
      const target = event.target, bar = target.type === "range" && target.id !== "scrub";
      const own = target.tagName === "SELECT" || bar || (event.key === " " && /BUTTON|INPUT/.test(target.tagName));
      if (own || event.ctrlKey || event.altKey || event.metaKey || !actions[event.key]) return;
      event.preventDefault();
      actions[event.key](event);
    });
  };
})(springnet);
