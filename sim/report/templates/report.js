"use strict";
const { x, text, left, width } = JSON.parse(document.getElementById("data").textContent);
const timeline = document.getElementById("timeline"), cursor = document.getElementById("cursor");
const readout = document.getElementById("readout");
let kept = null;

function show(k) {
  document.querySelectorAll("circle.now").forEach((dot) => dot.classList.remove("now"));
  cursor.setAttribute("x1", k === null ? -9 : x[k]);
  cursor.setAttribute("x2", k === null ? -9 : x[k]);
  readout.textContent = k === null ? "\u00a0" : text[k];
  if (k !== null) document.querySelectorAll(`circle[data-k="${k}"]`).forEach((dot) => dot.classList.add("now"));
}
function nearest(event) {
  const box = timeline.getBoundingClientRect(), at = (event.clientX - box.left) / box.width * width;
  if (at < left) return null;
  return x.reduce((best, value, k) => Math.abs(value - at) < Math.abs(x[best] - at) ? k : best, 0);
}
timeline.addEventListener("pointermove", (event) => show(nearest(event)));
timeline.addEventListener("pointerleave", () => show(kept));
timeline.addEventListener("click", (event) => show(kept = nearest(event)));
document.getElementById("plans").addEventListener("pointerover", (event) => {
  if (event.target.dataset.k !== undefined) show(Number(event.target.dataset.k));
});
document.querySelectorAll("[data-go]").forEach((element) => element.addEventListener("click", () => {
  show(kept = Number(element.dataset.go));
  document.querySelector(`circle[data-k="${kept}"]`)?.scrollIntoView({ behavior: "smooth", block: "center" });
}));
