// Parameters of the page's address, after '#': time=4&view=30,20&zoom=1.2&bare=1&play=0&color=speed&displacement=10.
(function (s) {
  const parameters = new URLSearchParams(location.hash.slice(1));
  function number(name, fallback) {
    const value = Number(parameters.get(name));
    return parameters.has(name) && isFinite(value) ? value : fallback;
  }
  function flag(name, fallback) { return parameters.has(name) ? parameters.get(name) !== "0" : fallback; }

  const view = (parameters.get("view") || "").split(",").map(Number);
  s.address = {
    time: parameters.has("time") ? number("time", 0) : null,
    azimuth: view.length === 2 && view.every(isFinite) ? view[0] : null,
    elevation: view.length === 2 && view.every(isFinite) ? view[1] : null,
    zoom: Math.max(0.01, number("zoom", 1)),
    bare: flag("bare", false), labels: flag("labels", true),
    play: flag("play", !parameters.has("time") && !parameters.has("bare")),
    selftest: flag("selftest", false)
  };
  ["springs", "broken", "nodes", "faces", "instruments", "forces", "touches", "learned", "start", "observed", "held_out", "velocities", "reactions"].forEach(function (what) { s.shown[what] = flag(what, s.shown[what]); });
  const colour = parameters.get("color") || parameters.get("colour");
  if (["tension", "speed", "contact"].includes(colour)) s.shown.colour = colour;
  const state = s.run.about.states.findIndex(function (each) { return each.label === colour; });
  if (state >= 0) s.shown.colour = "state" + state;
  // "spring.stiffness", or "spring.stiffness:ratio"
  s.run.learned.forEach(function (each, k) {
    each.kinds.forEach(function (kind) {
      if (colour === each.name + ":" + kind || (kind === "value" && colour === each.name)) s.shown.colour = "learned" + k + "." + kind;
    });
  });
  if (parameters.get("forces") === "nodes") s.shown.arrows = "nodes";
  const displacement = number("displacement", 1);
  if (displacement > 0) s.exaggeration = displacement;
  s.address.opacity = number("opacity", 0.8);
})(springnet);
