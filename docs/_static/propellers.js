// Filter the list of propellers.  Without this script, the box stays hidden and all are listed.
(() => {
  const box = document.querySelector(".propeller-filter");
  const input = box.querySelector("input");
  const told = box.querySelector("output");
  const items = [...document.querySelectorAll("#propeller-list > li")];

  // As in commands, "10 x 4,7" is 10x4.7.  "3 blades" is one word, so that it does not match 3x2.
  const words = (text) =>
    text
      .toLowerCase()
      .replace(/(\d)\s*[x×*]\s*(?=\d)/g, "$1x")
      .replace(/(\d),(?=\d)/g, "$1.")
      .replace(/(\d)[\s-]*blades?\b/g, "$1blades")
      .split(/[\s-]+/)
      .filter(Boolean);

  const filter = () => {
    const wanted = words(input.value);
    let shown = 0;
    for (const item of items) {
      item.hidden = !wanted.every((word) => item.dataset.words.includes(` ${word}`));
      shown += !item.hidden;
    }
    told.textContent = wanted.length ? `${shown} of ${items.length}` : `${items.length}`;
  };

  input.addEventListener("input", filter);
  input.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      input.value = "";
      filter();
    }
  });
  box.hidden = false;
  filter(); // The browser restores the typed text when the user goes back.
})();
