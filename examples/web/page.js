// What belongs to no tab: choosing one of them, and settings that come with the address, as in
// #scene=rtrt&mode=drt&size=256x256: the names are ids of controls, and `tab` is one of "look" and "walk".
export const byId = (id) => document.getElementById(id);

const tabs = [...document.querySelectorAll('[role="tab"]')];

// Shows a tab. Its section hears of it by an event "shown", the one that was seen before by "hidden".
function showTab(tab) {
  for (const other of tabs) {
    const section = byId(other.getAttribute("aria-controls")), wasHidden = section.hidden;
    other.setAttribute("aria-selected", other === tab);
    other.tabIndex = other === tab ? 0 : -1;
    section.hidden = other !== tab;
    if (section.hidden !== wasHidden) section.dispatchEvent(new Event(section.hidden ? "hidden" : "shown"));
  }
}

// What is seen in a tab, as an address: each tab's script says, by the name of its section.
export const addresses = { look: () => "", walk: () => "#walk" };

// Whoever chooses a tab can go back.
function choose(tab) {
  const named = tab.getAttribute("aria-controls"), hash = addresses[named]();
  if (byId(named).hidden) document.querySelector('[role="tabpanel"]:not([hidden])').dispatchEvent(new Event("leaving"));
  if (byId(named).hidden) history.pushState(null, "", hash || location.pathname + location.search);
  showTab(tab);
}

for (const tab of tabs) {
  tab.addEventListener("click", () => choose(tab));
  tab.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const next = tabs[(tabs.indexOf(tab) + step + tabs.length) % tabs.length];
    next.focus();
    choose(next);
  });
}

// Where there is no room for all panels, they are shown one at a time, by a row of buttons.
const panelButtons = [...document.querySelectorAll(".panels button")];
function openPanel(button, opened) {
  for (const other of button.parentElement.children) {
    const open = opened && other === button;
    other.setAttribute("aria-expanded", open);
    byId(other.getAttribute("aria-controls")).classList.toggle("opened", open);
  }
}
if (matchMedia("(min-width: 56rem)").matches) openPanel(panelButtons[0], true); // beside the picture one is open from the start
for (const button of panelButtons)
  button.addEventListener("click", () => openPanel(button, button.getAttribute("aria-expanded") !== "true"));
document.addEventListener("keydown", (event) => {
  const button = panelButtons.find((one) => one.getAttribute("aria-expanded") === "true" && one.offsetParent);
  const panel = button && byId(button.getAttribute("aria-controls"));
  if (event.key !== "Escape" || !panel || !(panel.contains(event.target) || event.target === button)) return;
  openPanel(button, false);
  button.focus();
});

// The address is of one tab; that of the first has no name in it, or none.
addEventListener("hashchange", () => {
  const named = isWalk() ? "walk" : "look";
  const tab = tabs.find((one) => one.getAttribute("aria-controls") === named);
  if (tab.getAttribute("aria-selected") !== "true") showTab(tab);
});

// Compiles the module once for all who want an instance of it, workers and the page itself.
let compiled = null;
export function moduleCode() {
  compiled ??= fetch("pktrt.wasm").then(async (answer) => {
    if (!answer.ok) throw new Error(`pktrt.wasm: ${answer.status} ${answer.statusText}`);
    return WebAssembly.compile(await answer.arrayBuffer());
  });
  return compiled;
}

// (#walk?... is for the other tab, and its names are other ones: walk_data.js has them.)
export const isWalk = () => /^#walk\b/.test(location.hash);
export const given = new URLSearchParams(isWalk() ? "tab=walk" : location.hash.slice(1));

// Sets a control to what an address says of it.
export function setControl(id, value) {
  const control = byId(id);
  if (!control || !("value" in control) || control.type === "file") return;
  if (control.type === "checkbox") control.checked = value !== "0";
  else if (!control.options || [...control.options].some((one) => one.value === value)) control.value = value;
}
for (const [id, value] of given) setControl(id, value);
// After all scripts have run, so that they hear of it.
addEventListener("DOMContentLoaded", () => {
  const tab = tabs.find((one) => one.getAttribute("aria-controls") === given.get("tab"));
  if (tab) showTab(tab);
});
