// Everything is there: read the address, show what it asks for.
if (sections.length) startFilter();
if (canvas) startControls();
addEventListener("hashchange", readState);
readState();
if (sections.length) openSections();
hint();
if (canvas) showStage();
document.documentElement.dataset.ready = `after ${Math.round(performance.now())} ms`;
