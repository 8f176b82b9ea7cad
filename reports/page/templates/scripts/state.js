// The whole state of the view, in the address: a link shows what its sender saw.
const usual = {
  f: "", only: "", sort: "", s: "", r: "", q: "", m: "side", p: "", v: "", d: "bands", o: "uwp", at: "",
  open: "",
};
const state = { ...usual };
const listeners = [];

function readState() {
  const text = location.hash.slice(1);
  if (text && !text.includes("=")) {  // a link to a section: it joins the state
    change({ at: decodeURIComponent(text) });
    return;
  }
  const given = new URLSearchParams(text);
  for (const key of Object.keys(usual)) state[key] = given.get(key) ?? usual[key];
  tell(Object.keys(usual));
}

function change(changes) {
  const changed = Object.keys(changes).filter((key) => state[key] !== String(changes[key]));
  for (const key of changed) state[key] = String(changes[key]);
  const kept = Object.entries(state).filter(([key, value]) => value !== usual[key]);
  const hash = new URLSearchParams(kept).toString();
  history.replaceState(null, "", hash ? `#${hash}` : location.pathname + location.search);
  tell(Object.keys(changes));
}

function tell(keys) {
  for (const [wanted, act] of listeners) if (wanted.some((key) => keys.includes(key))) act();
}

const on = (keys, act) => listeners.push([keys, act]);
