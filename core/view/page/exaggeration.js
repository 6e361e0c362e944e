// Displacements from the first record, drawn larger than they are. Only what is drawn: numbers stay true.
(function (s) {
  const run = s.run, width = 3 * run.nodes, start = Float32Array.from(run.positions.row(0)), drawn = new Float32Array(width);
  let size = 0, largest = 0;

  function larger(value, k) { return start[k] + s.exaggeration * (value - start[k]); }
  s.exaggeration = 1;
  // Coordinate k of all frames, and those of a frame as they are drawn; these are valid until the next call.
  s.place_at = function (k) {
    const value = run.positions.at(k);
    return s.exaggeration === 1 ? value : larger(value, k % width);
  };
  s.places = function (frame) {
    const row = run.positions.row(frame);
    if (s.exaggeration === 1) return row;
    for (let k = 0; k < width; ++k) drawn[k] = larger(row[k], k);
    return drawn;
  };

  // As far as the network moves by its own size, and numbers have the digits for it.
  function largest_useful() {
    let low = Infinity, high = -Infinity;
    for (let k = 0; k < width; ++k) { low = Math.min(low, start[k]); high = Math.max(high, start[k]); }
    size = high - low;
    for (let k = width; k < run.positions.numbers; ++k) largest = Math.max(largest, Math.abs(run.positions.at(k) - start[k % width]));
    if (!(size > 0) || !(largest > 0)) return 1;
    const step = run.positions.step || s.float_step * Math.max(Math.abs(low), Math.abs(high));
    return Math.max(10, Math.min(size / largest, step > 0 ? 0.02 * size / step : Infinity, 1e6));
  }
  s.exaggerations = [1];
  const most = largest_useful();
  for (let power = 1; power <= 1e6; power *= 10) {
    [1, 2, 5].forEach(function (digit) { if (digit * power > 1 && digit * power <= most) s.exaggerations.push(digit * power); });
  }
  s.moves = largest > 0;
})(springnet);
