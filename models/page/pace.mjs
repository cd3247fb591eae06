// How much the page draws: less on a machine whose pictures take long, and nothing while nothing changes. It begins with the
// least, so that the first pictures come early on any machine, and draws more while they come evenly.
const k_steps = [
  [2, true, 1],
  [1.5, true, 1],
  [1, true, 0.5],
  [1, false, 0.25],
  [0.7, false, 0.25],
  [0.5, false, 0.25],
  [0.35, false, 0.125],
].map(([pixels, smooth, loose]) => ({ pixels, smooth, loose }));
const k_last = k_steps.length - 1;
const k_sharp = 4; // the coarsest that still looks sharp
const k_slow = 24;
const k_even = 19; // milliseconds from picture to picture: draw less; there may be room for more
const k_very_slow = 80; // for less than is sharp
const k_pictures = 20; // that are looked at together
const k_few = 3; // where they take long, and of the first ones
const k_long = 300; // milliseconds of those few
const k_patience = 12; // so often they must be even before more is tried; twice as often after each failure
const k_most = 384;
const k_awake_ms = 700; // after the last touch

export class Pace {
  #intervals = [];
  #even = 0;
  #patience = k_patience;
  #since = 0; // a better step was taken, in looks
  #first = true;
  #woken = performance.now();
  step = k_last;
  // Of a picture: its pixels for one of CSS at most, whether edges are smooth, and the share of loose grains.
  get now() {
    return k_steps[this.step];
  }
  get said() {
    return this.step === 0 ? "in full" : `coarser by ${this.step} of ${k_last}, pictures take long`;
  }

  // A picture came so long after the one before, without the time that sand took.
  drew(ms) {
    const count = this.#intervals.push(ms);
    const sum = this.#intervals.reduce((a, b) => a + b, 0);
    if (count < k_few || (count < k_pictures && sum < k_long && !this.#first)) return;
    const middle = this.#intervals.sort((a, b) => a - b)[count >> 1];
    this.#intervals = [];
    ++this.#since;
    this.#even = middle < k_even ? this.#even + 1 : 0;
    if (middle > (this.step < k_sharp ? k_slow : k_very_slow)) {
      if (!this.#first && this.#since < k_patience) this.#patience = Math.min(k_most, 2 * this.#patience);
      const halvings = Math.max(1, Math.round(Math.log2(middle / k_slow))); // a step takes about half of the one before
      this.step = Math.min(k_last, this.step + halvings);
      this.#even = 0;
      this.#first = false;
    } else if (this.step > 0 && this.#even >= (this.#first ? 1 : this.#patience)) {
      --this.step;
      this.#even = this.#since = 0;
    } else if (this.#even === 0) this.#first = false;
  }

  wake() {
    this.#woken = performance.now();
  }
  get touched() {
    return performance.now() - this.#woken < k_awake_ms;
  }
}
