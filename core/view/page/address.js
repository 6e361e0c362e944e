// What the page's address asks for after '#': time=4&view=30,20&zoom=1.2&bare=1&play=0&color=speed&displacement=10.
(function (s) {
  const asked = new URLSearchParams(location.hash.slice(1));
  function number(name, other) {
    const value = Number(asked.get(name));
    return asked.has(name) && isFinite(value) ? value : other;
  }
  function on(name, other) { return asked.has(name) ? asked.get(name) !== "0" : other; }

  const view = (asked.get("view") || "").split(",").map(Number);
  s.address = {
    time: asked.has("time") ? number("time", 0) : null,
    azimuth: view.length === 2 && view.every(isFinite) ? view[0] : null,
    elevation: view.length === 2 && view.every(isFinite) ? view[1] : null,
    zoom: Math.max(0.01, number("zoom", 1)),
    bare: on("bare", false), labels: on("labels", true),
    play: on("play", !asked.has("time") && !asked.has("bare")),
    selftest: on("selftest", false)
  };
  ["springs", "broken", "nodes", "faces", "instruments", "forces"].forEach(function (what) { s.shown[what] = on(what, s.shown[what]); });
  const colour = asked.get("color") || asked.get("colour");
  if (["tension", "speed", "contact"].includes(colour)) s.shown.colour = colour;
  if (asked.get("forces") === "nodes") s.shown.arrows = "nodes";
  const displacement = number("displacement", 1);
  if (displacement > 0) s.exaggeration = displacement;
  s.address.opacity = number("opacity", 0.8);
})(springnet);
