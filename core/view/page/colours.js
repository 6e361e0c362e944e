// Colour maps (256 colours of three bytes each), and numbers as text.
(function (s) {
  function table(stops) {
    const colours = new Uint8Array(3 * 256);
    for (let k = 0; k < 256; ++k) {
      const position = k / 255 * (stops.length - 1);
      const lower = Math.min(Math.floor(position), stops.length - 2);
      for (let c = 0; c < 3; ++c) {
        colours[3 * k + c] = stops[lower][c] + (position - lower) * (stops[lower + 1][c] - stops[lower][c]);
      }
    }
    return colours;
  }
  // Compression blue, slack grey, tension red; at rest dark blue-grey, fast orange to yellow.
  const diverging = table([[12, 44, 132], [33, 102, 192], [110, 165, 215], [186, 190, 196], [232, 135, 108], [206, 44, 48], [128, 0, 32]]);
  const sequential = table([[120, 130, 145], [66, 90, 160], [125, 60, 150], [205, 70, 100], [240, 130, 45], [250, 190, 30]]);

  // Of learned values, none of them grey: that is the colour of what is not determined.
  const learned = table([[68, 1, 84], [62, 74, 137], [38, 130, 142], [53, 183, 121], [160, 218, 57], [253, 221, 30]]);
  const ratio = table([[24, 60, 160], [40, 150, 220], [232, 216, 130], [240, 120, 50], [150, 10, 40]]);

  s.colours = {
    tension: { table: diverging },
    learned: learned, ratio: ratio, open: [150, 150, 150], start: [225, 110, 20], observed: [10, 130, 60], held_out: [150, 30, 190],
    velocity: [0, 110, 170], reaction: [170, 70, 0],
    speed: { table: sequential },
    free: [92, 104, 118], fixed: [0, 0, 0], moved: [120, 40, 160], contact: [240, 130, 20], plain: [140, 148, 158], without: [228, 231, 235], rigid: [40, 44, 50],
    force: [26, 127, 70], touch: [196, 16, 120],
    // Offset in a table of the colour of `value`, for values up to `range`.
    offset: function (value, range, symmetric) {
      const share = range > 0 ? value / range : 0;
      const position = symmetric ? 0.5 + 0.5 * share : share;
      return 3 * Math.round(255 * Math.min(1, Math.max(0, position)));
    }
  };

  // 1, 2 or 5 times a power of ten: the next at or below the number, or at or above it.
  s.round_down = function (number) {
    const power = Math.pow(10, Math.floor(Math.log10(number)));
    const digit = number / power;
    return (digit >= 5 ? 5 : digit >= 2 ? 2 : 1) * power;
  };
  s.round_up = function (number) {
    const power = Math.pow(10, Math.floor(Math.log10(number)));
    const digit = number / power * (1 - 1e-9);
    return (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10) * power;
  };
  s.number = function (value, digits) {
    if (value === null || !isFinite(value)) return "–";
    const text = String(Number(value.toPrecision(digits || 4)));
    return text.replace("e+", "e").replace(/^-/, "−");
  };
  // Rounds the value to its significant digits: to the power of ten at or above `step`. Step 0 leaves it as it is.
  s.round_to = function (value, step) {
    if (!(step > 0)) return value;
    const unit = Math.pow(10, Math.ceil(Math.log10(step) - 1e-9));
    return Math.round(value / unit) * unit;
  };
  // [size, name] of the unit that suits values up to `max`, which are in the unit `si`: that unit, or a multiple of it.
  const multiples = {
    N: [[1e9, "GN"], [1e6, "MN"], [1e3, "kN"], [1, "N"], [1e-3, "mN"], [1e-6, "µN"], [1e-9, "nN"]],
    J: [[1e9, "GJ"], [1e6, "MJ"], [1e3, "kJ"], [1, "J"], [1e-3, "mJ"], [1e-6, "µJ"], [1e-9, "nJ"], [1e-12, "pJ"]],
    m: [[1e3, "km"], [1, "m"], [1e-3, "mm"], [1e-6, "µm"], [1e-9, "nm"]],
    "m^2": [[1, "m²"], [1e-4, "cm²"], [1e-6, "mm²"], [1e-12, "µm²"]],
    "m^3": [[1, "m³"], [1e-3, "dm³"], [1e-6, "cm³"], [1e-9, "mm³"], [1e-18, "µm³"]]
  };
  s.unit_for = function (si, max) {
    const all = multiples[si];
    if (!all) return [1, si];
    if (!(max > 0)) return all.find(function (each) { return each[0] === 1; });
    return all.find(function (each) { return max >= each[0] * (1 - 1e-9); }) || all[all.length - 1];
  };
  s.force_text = function (newtons) {
    const unit = s.unit_for("N", newtons);
    return s.number(newtons / unit[0], 3) + " " + unit[1];
  };
  // A length in a suitable unit.
  s.length_text = function (metres) {
    const units = [[1000, "km"], [1, "m"], [0.01, "cm"], [0.001, "mm"], [1e-6, "µm"]];
    const unit = units.find(function (each) { return metres >= each[0] * (1 - 1e-9); }) || units[units.length - 1];
    return s.number(metres / unit[0]) + " " + unit[1];
  };
})(springnet);
