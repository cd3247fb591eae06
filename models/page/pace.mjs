// How much the page draws: less on a machine whose pictures take long, and nothing while nothing changes.
const k_steps = [{ pixels: 2, loose: 1 }, { pixels: 1.5, loose: 1 }, { pixels: 1, loose: 0.5 }, { pixels: 0.75, loose: 0.25 }];
const k_slow = 24, k_even = 19;       // milliseconds from picture to picture: draw less; there may be room for more
const k_pictures = 20, k_few = 3;     // that are looked at together; fewer where they take long
const k_long = 600;                   // milliseconds of those few
const k_patience = 12, k_most = 384;  // so often they must be even before more is tried; twice as often after each failure
const k_awake_ms = 700;               // after the last touch

export class Pace {
  #intervals = [];
  #even = 0;
  #patience = k_patience;
  #since = 0;    // a better step was taken, in looks
  #woken = performance.now();
  step = 0;
  // Of a picture: pixels of the screen's at most, and the share of loose grains.
  get now() { return k_steps[this.step]; }

  drew(ms) {
    const count = this.#intervals.push(ms), sum = this.#intervals.reduce((a, b) => a + b, 0);
    if (count < k_pictures && (count < k_few || sum < k_long)) return;
    const middle = this.#intervals.sort((a, b) => a - b)[count >> 1];
    this.#intervals = [], ++this.#since;
    this.#even = middle < k_even ? this.#even + 1 : 0;
    if (middle > k_slow && this.step + 1 < k_steps.length) {
      if (this.#since < k_patience) this.#patience = Math.min(k_most, 2 * this.#patience);
      ++this.step, this.#even = 0;
    } else if (this.step > 0 && this.#even >= this.#patience) --this.step, this.#even = this.#since = 0;
  }

  wake() { this.#woken = performance.now(); }
  get touched() { return performance.now() - this.#woken < k_awake_ms; }
}
