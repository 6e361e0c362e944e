// A page of figures, and the script that shows the values at the pointer in any page that has them.
#pragma once

namespace springnet::tool {

// For the <svg> in #figures, with the data of its panels in #panels and a box #values.
inline constexpr const char* plot_style =
    R"(#values { position: fixed; z-index: 4; display: none; padding: 6px 9px; background: #ffffff; border: 1px solid #1a1a1a; white-space: pre;
  font: 13px "DejaVu Sans", Verdana, Helvetica, Arial, sans-serif; color: #1a1a1a; pointer-events: none; }
)";
inline constexpr const char* plot_script = R"("use strict";
(function () {
  const panels = JSON.parse(document.getElementById("panels").textContent);
  const svg = document.querySelector("#figures svg"), values = document.getElementById("values");
  const cursor = document.createElementNS(svg.namespaceURI, "line");
  cursor.setAttribute("stroke", "#1a1a1a");
  cursor.setAttribute("visibility", "hidden");
  svg.append(cursor);
  const digits = function (number) {
    return number === null ? "not finite" : String(Number(number.toPrecision(5))).replace("-", "\u2212");
  };
  // The point of a curve next to the pointer: by x, or on a path by the distance.
  const nearest = function (panel, curve, x, y) {
    const width = panel.x[1] - panel.x[0], height = panel.y[1] - panel.y[0];
    let best = 0, least = Infinity;
    curve.x.forEach(function (at, k) {
      if (at === null) return;
      const dx = (at - x) / width, dy = panel.is_path && curve.y[k] !== null ? (curve.y[k] - y) / height : 0;
      if (dx * dx + dy * dy < least) { least = dx * dx + dy * dy; best = k; }
    });
    return best;
  };
  const hide = function () {
    values.style.display = "none";
    cursor.setAttribute("visibility", "hidden");
  };
  svg.addEventListener("pointerleave", hide);
  svg.addEventListener("pointermove", function (event) {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const panel = panels.find(function (each) {
      return at.x >= each.frame[0] && at.x <= each.frame[2] && at.y >= each.frame[1] && at.y <= each.frame[3];
    });
    if (!panel) return hide();
    const f = panel.frame;
    const x = panel.x[0] + (at.x - f[0]) / (f[2] - f[0]) * (panel.x[1] - panel.x[0]);
    const y = panel.y[1] - (at.y - f[1]) / (f[3] - f[1]) * (panel.y[1] - panel.y[0]);
    let text = "", place = x;
    panel.curves.forEach(function (curve) {
      const k = nearest(panel, curve, x, y);
      if (text === "") { place = curve.x[k]; text = panel.x_label + ": " + digits(place); }
      text += "\n" + (curve.label || panel.y_label) + ": " + digits(curve.y[k]);
      if (curve.from && curve.from[k] !== null) text += " [" + digits(curve.from[k]) + " to " + digits(curve.to[k]) + "]";
});
const pixel = f[0] + (place - panel.x[0]) / (panel.x[1] - panel.x[0]) * (f[2] - f[0]);
cursor.setAttribute("x1", pixel);
cursor.setAttribute("x2", pixel);
cursor.setAttribute("y1", f[1]);
cursor.setAttribute("y2", f[3]);
cursor.setAttribute("visibility", "visible");
values.textContent = text;
values.style.display = "block";
const box = values.getBoundingClientRect();
values.style.left = Math.min(event.clientX + 14, innerWidth - box.width - 4) + "px";
values.style.top = Math.min(event.clientY + 14, innerHeight - box.height - 4) + "px";
});
})();
)";

// Placeholders of fmt: title, <svg>, data of the panels as JSON, plot_script, plot_style.
inline constexpr const char* plot_page = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{0}</title>
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body {{ margin: 0; background: #ffffff; }}
svg {{ display: block; margin: 0 auto; max-width: 100%; height: auto; touch-action: pan-y; }}
{4}</style></head><body>
<div id="figures">
{1}</div><div id="values" role="status"></div>
<script type="application/json" id="panels">{2}</script>
<script>
{3}</script></body></html>
)";

}  // namespace springnet::tool
