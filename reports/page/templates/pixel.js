// The page of one pixel: its picture in space, and what can be copied.
const data = JSON.parse(one("#data").textContent);
for (const part of all(".scripted")) part.hidden = false;
for (const button of all("[data-copy]")) {
  button.addEventListener("click", () => copy(one(button.dataset.copy).textContent, button));
}
startSpace();
showSpace(data);
document.documentElement.dataset.ready = "yes";
