// The page's elements, and its one line of speech.
export const by = (id) => document.getElementById(id);
export const say = (sentence) => {
  by("says").textContent = sentence;
};
export const counted = (number) => String(number).replace(/\B(?=(\d{3})+$)/g, ","); // "4,200"
