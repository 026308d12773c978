// Shows one picture of each view at a time, and flips prediction and truth in place.
(() => {
  const gallery = document.getElementById("gallery");
  document.documentElement.classList.add("js");
  const names = { truth: "Truth", prediction: "Prediction", difference: "Difference", coverage: "Coverage" };

  function thumb(view, kind) {
    const way = gallery.dataset.way;
    return view.querySelector(`[data-of="${way}"] [data-kind="${kind}"], .strip > [data-kind="${kind}"]`);
  }

  function show(view, kind) {
    const chosen = thumb(view, kind);
    view.dataset.kind = kind;
    const flip = kind === "prediction" ? "truth" : "prediction";
    view.querySelector(".stage img").src = chosen.querySelector("img").src;
    view.querySelector(".stage img").alt = chosen.querySelector("img").alt;
    view.querySelector(".badge").innerHTML = `${names[kind]} <i>tap for ${names[flip].toLowerCase()}</i>`;
    for (const button of view.querySelectorAll(".strip [data-kind] button")) {
      button.setAttribute("aria-pressed", String(button === chosen.querySelector("button")));
    }
  }

  function choose(way) {
    gallery.dataset.way = way;
    for (const button of gallery.querySelectorAll(".switch button")) {
      button.setAttribute("aria-pressed", String(button.dataset.choose === way));
    }
    for (const part of gallery.querySelectorAll("[data-of]")) {
      const shown = part.classList.contains("numbers") ? "grid" : "contents";
      part.style.display = part.dataset.of === way ? shown : "none";
    }
    for (const view of gallery.querySelectorAll(".view")) show(view, view.dataset.kind || "prediction");
  }

  gallery.addEventListener("click", (event) => {
    const button = event.target.closest("button");
    if (!button) return;
    if (button.dataset.choose) return choose(button.dataset.choose);
    const view = button.closest(".view");
    const figure = button.closest("[data-kind]:not(.view)");
    if (figure) show(view, figure.dataset.kind);
    else show(view, view.dataset.kind === "prediction" ? "truth" : "prediction");
  });

  choose(gallery.dataset.way);
})();
