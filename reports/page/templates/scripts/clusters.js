// Lists beside the stage: clusters, the worst pixels, and how the errors are distributed.
let place = -1;

function showLists() {
  const { scene, reference, name } = shown;
  place = -1;
  const go = (each) => element("button", { type: "button", className: "pixel",
    onclick: () => pick(each.column, each.row, true) }, `(${each.column}, ${each.row})`);
  const clusters = reference.clusters.map((each, k) => element("tr", {},
    element("td", { className: "num" }, `${k + 1}`), element("td", {}, each.stage), element("td", { className: "num" }, `${each.size}`),
    element("td", { className: "num" }, `${each.left}–${each.right} × ${each.top}–${each.bottom}`), element("td", {}, go(each))));
  const worst = reference.worst.map((each) => element("tr", {}, element("td", {}, go(each)), element("td", {}, each.stage),
    element("td", {}, each.quantity), element("td", { className: "num" }, times(finite(each.ratio)))));
  const none = (rows, made, words) => (rows.length ? made : element("p", { className: "soft" }, words));
  const passes = `${reference.name} has no wrong pixel on ${scene.name}.`;
  const left = reference.clusterCount - clusters.length;
  one("#clusters").replaceChildren(none(clusters, element("div", { className: "wide tall", tabIndex: 0, role: "region", "aria-label": "Clusters" },
    table("Clusters of wrong pixels", ["", "stage", "pixels", "columns × rows", "worst"], clusters)), passes),
  ...(left > 0 ? [element("p", { className: "soft" }, `and ${counted(left, "more cluster")}`)] : []));
  one("#worst").replaceChildren(none(worst, element("div", { className: "wide tall", tabIndex: 0, role: "region", "aria-label": "Worst pixels" },
    table("Worst pixels", ["pixel", "stage", "quantity", "error ÷ tol."], worst)), passes));
  one("#histogram-title").textContent = `Errors of ${name}, ${reference.name}`;
  one("#histogram").replaceChildren(histogram(reference.quantities[name].histogram));
}

// A histogram that is its own table: a bar a row.
function histogram({ counts, differences }) {
  const judged = counts.slice(0, -1), total = counts.reduce((a, b) => a + b, 0), most = Math.max(...counts, 1);
  const share = (n) => (n === total ? "100 %" : `${Math.min(99.99, 100 * n / total).toFixed(2)} %`);
  let sum = 0;
  const bounds = data.bounds.map((b) => (b > 0 && b < 1 ? `1/${1 / b}` : `${b}`));
  const rows = judged.map((n, k) => {
    sum += n;
    const words = k === 0 ? "0" : k === judged.length - 1 ? `> ${bounds.at(-1)}` : `≤ ${bounds[k]}`;
    return row(words, n, differences[k], share(n), share(sum), data.bands[k], data.bounds[k] === 1);
  });
  rows.push(row("uncertain", counts.at(-1), differences.at(-1), share(counts.at(-1)), "", data.hatch[0], false));
  function row(words, n, difference, part, upTo, color, last) {
    // Of few pixels among many the bar is never nothing.
    const width = n ? Math.max(1, 100 * Math.log1p(n) / Math.log1p(most)) : 0;
    return element("tr", { className: last ? "tolerance" : "" }, element("th", { scope: "row" }, words), element("td", { className: "num" }, spelled(finite(difference), 2)),
      element("td", { className: "num" }, `${n}`), element("td", { className: "num" }, part), element("td", { className: "num" }, upTo),
      element("td", {}, element("span", { className: "histogram", style: `width:${width}%;background:${color}` })));
  }
  return table("Pixels by error over tolerance", ["error ÷ tol.", "error up to", "pixels", "share", "up to here", "bar, log"], rows);
}

function nextCluster(step) {
  const { clusters } = shown.reference ?? { clusters: [] };
  if (!clusters.length) return;
  place = (place + step + clusters.length) % clusters.length;
  const each = clusters[place];
  pick(each.column, each.row, true);
  one("#stage-status").textContent = `cluster ${place + 1} of ${clusters.length}: ${counted(each.size, "pixel")}, first wrong in ${each.stage}`;
}

function nextScene(step) {
  const scenes = comparable().filter((scene) => !document.getElementById(scene.id)?.hidden);
  if (!scenes.length) return;
  const here = scenes.indexOf(shown.scene), next = scenes[(here + step + scenes.length) % scenes.length];
  change({ s: next.id, r: "", q: "", p: "", v: "" });
  one("#stage-status").textContent = `scene ${next.name}, ${next.state}`;
}
