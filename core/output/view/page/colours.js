// Colours of numbers: tables of 256 colours, three bytes each.
(function (s) {
  function table(stops) {
    const colours = new Uint8Array(3 * 256);
    for (let k = 0; k < 256; ++k) {
      const place = k / 255 * (stops.length - 1);
      const lower = Math.min(Math.floor(place), stops.length - 2);
      for (let c = 0; c < 3; ++c) {
        colours[3 * k + c] = stops[lower][c] + (place - lower) * (stops[lower + 1][c] - stops[lower][c]);
      }
    }
    return colours;
  }
  // Compression blue, slack grey, tension red; at rest dark blue-grey, fast orange to yellow.
  const diverging = table([[12, 44, 132], [33, 102, 192], [110, 165, 215], [186, 190, 196], [232, 135, 108], [206, 44, 48], [128, 0, 32]]);
  const sequential = table([[120, 130, 145], [66, 90, 160], [125, 60, 150], [205, 70, 100], [240, 130, 45], [250, 190, 30]]);

  s.colours = {
    tension: { table: diverging, symmetric: true },
    speed: { table: sequential, symmetric: false },
    free: [92, 104, 118], fixed: [0, 0, 0], moved: [120, 40, 160], contact: [240, 130, 20], plain: [140, 148, 158], rigid: [40, 44, 50],
    // Offset in a table of the share of `range` that `value` is.
    offset: function (value, range, symmetric) {
      const share = range > 0 ? value / range : 0;
      const place = symmetric ? 0.5 + 0.5 * share : share;
      return 3 * Math.round(255 * Math.min(1, Math.max(0, place)));
    }
  };

  // 1, 2 or 5 times a power of ten, not above / not below the number.
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
  // A length in the unit that suits it.
  s.length_text = function (metres) {
    const units = [[1000, "km"], [1, "m"], [0.01, "cm"], [0.001, "mm"], [1e-6, "µm"]];
    const unit = units.find(function (each) { return metres >= each[0] * (1 - 1e-9); }) || units[units.length - 1];
    return s.number(metres / unit[0]) + " " + unit[1];
  };
})(springnet);
