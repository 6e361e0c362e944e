// Plays the records: which one is shown, speed, loop.
(function (s) {
  const run = s.run, last = run.frames - 1;
  const speeds = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 1000];

  s.Player = function (show) {
    const player = this;
    let last_tick = 0;  // ms, of the browser's clock; 0: none yet
    this.frame = 0;
    this.time = run.times[0];
    this.playing = false;
    this.loop = true;
    this.speeds = speeds;
    // Real time, unless the run would take less than a second or more than a minute: then about ten seconds.
    const span = run.times[last] - run.times[0];
    this.speed = 1;
    if (span > 0 && (span < 1 || span > 60)) {
      this.speed = speeds.reduce(function (best, each) {
        return Math.abs(Math.log(span / each / 10)) < Math.abs(Math.log(span / best / 10)) ? each : best;
      });
    }

    this.go = function (frame) {
      player.frame = Math.min(last, Math.max(0, frame));
      player.time = run.times[player.frame];
      show(player.frame);
    };
    this.go_to_time = function (time) { player.go(run.frame_at(time)); };
    this.step = function (frames) { player.pause(); player.go(player.frame + frames); };
    this.pause = function () { player.playing = false; player.on_change(); };
    this.toggle = function () {
      player.playing = !player.playing;
      if (player.playing && player.frame === last) player.go(0);
      last_tick = 0;
      player.on_change();
      if (player.playing) requestAnimationFrame(tick);
    };
    this.on_change = function () {};

    function tick(now) {
      if (!player.playing) return;
      if (last_tick > 0) {
        player.time += (now - last_tick) / 1000 * player.speed;
        if (player.time >= run.times[last]) {
          player.time = player.loop ? run.times[0] : run.times[last];
          if (!player.loop) player.pause();
        }
        const frame = run.frame_at(player.time);
        if (frame !== player.frame) {
          player.frame = frame;
          show(frame);
        }
      }
      last_tick = now;
      requestAnimationFrame(tick);
    }
  };
})(springnet);
