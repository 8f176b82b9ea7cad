// The page as a whole: what is enlarged, what scrolls, and the start.
const data = JSON.parse(one("#data").textContent);

function enlarge(entry) {
  const large = entry.querySelector(".small").classList.toggle("large");
  entry.querySelector(".larger").setAttribute("aria-pressed", large);
}

function hint() {
  for (const scroller of all(".scroller")) {
    const { scrollLeft, clientWidth, scrollWidth } = scroller.firstElementChild;
    scroller.classList.toggle("more", scrollLeft + clientWidth < scrollWidth - 2);
  }
}

addEventListener("click", (event) => {
  const entry = event.target.closest(".larger, .small .pic")?.closest(".entry");
  if (entry) enlarge(entry);
});
for (const scroller of all(".scroller")) scroller.firstElementChild.addEventListener("scroll", hint);
for (const part of all(".scripted")) part.hidden = false;
addEventListener("resize", hint);
