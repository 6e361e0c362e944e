// Exaggerates displacements from the first record. Only the drawing changes, values stay true.
(function (s) {
  const run = s.run, width = 3 * run.nodes, start = Float32Array.from(run.positions.row(0)), drawn = new Float32Array(width);
  let size = 0, largest = 0;

  function exaggerated(value, k) { return start[k] + s.exaggeration * (value - start[k]); }
  s.exaggeration = 1;
  // As drawn: coordinate k of all frames, and all coordinates of a frame, which are valid until the next call.
  s.drawn_coordinate = function (k) {
    const value = run.positions.at(k);
    return s.exaggeration === 1 ? value : exaggerated(value, k % width);
  };
  s.drawn_positions = function (frame) {
    const row = run.positions.row(frame);
    if (s.exaggeration === 1) return row;
    for (let k = 0; k < width; ++k) drawn[k] = exaggerated(row[k], k);
    return drawn;
  };

  // The motion of the start, and the observed places; those that belong to no node are not drawn larger, but left out.
  const drawn_start = new Float32Array(run.start_positions ? width : 0);
  s.drawn_start = function (frame) {
    const row = run.start_positions.row(frame);
    if (s.exaggeration === 1) return row;
    for (let k = 0; k < width; ++k) drawn_start[k] = exaggerated(row[k], k);
    return drawn_start;
  };
  s.drawn_observed = function (frame) {
    const seen = run.observed(frame), out = { places: [], held: [] };
    seen.nodes.forEach(function (node, k) {
      const held = seen.kinds[k] >= 4;
      if ((seen.kinds[k] & 3) !== 0 || !(held ? s.shown.held_out : s.shown.observed)) return;
      if (s.exaggeration !== 1 && node === run.never) return;
      out.held.push(held);
      for (let c = 0; c < 3; ++c) {
        const value = seen.points[3 * k + c];
        out.places.push(s.exaggeration === 1 ? value : exaggerated(value, 3 * node + c));
      }
    });
    return out;
  };

  // The factor at which the network moves by its own size, or the rounding of positions becomes visible.
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
  const max = largest_useful();
  for (let power = 1; power <= 1e6; power *= 10) {
    [1, 2, 5].forEach(function (digit) { if (digit * power > 1 && digit * power <= max) s.exaggerations.push(digit * power); });
  }
  s.has_motion = largest > 0;
})(springnet);
