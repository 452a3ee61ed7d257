// Search within the book: all words must occur in a section. The pages are readable without this script.
const box = document.getElementById("search"), input = box.querySelector("input"), list = box.querySelector("ol");
box.hidden = false;
input.addEventListener("input", () => {
  const words = input.value.toLowerCase().split(/\s+/).filter(w => w.length > 1);
  list.replaceChildren();
  if (!words.length) return;
  const hits = BOOK.map(([link, chapter, heading, text]) => {
    const lower = text.toLowerCase(), head = heading.toLowerCase();
    if (!words.every(w => lower.includes(w) || head.includes(w))) return null;
    const score = words.reduce((s, w) => s + lower.split(w).length - 1 + (head.includes(w) ? 20 : 0), 0);
    return {link, chapter, heading, text, score, at: Math.max(0, lower.indexOf(words[0]))};
  }).filter(Boolean).sort((a, b) => b.score - a.score).slice(0, 20);
  for (const hit of hits) {
    const item = document.createElement("li"), a = document.createElement("a"), p = document.createElement("p");
    a.href = hit.link;
    a.textContent = hit.heading === hit.chapter ? hit.chapter : hit.chapter + " · " + hit.heading;
    p.textContent = "… " + hit.text.slice(Math.max(0, hit.at - 60), hit.at + 100) + " …";
    item.append(a, p);
    list.append(item);
  }
  if (!hits.length) list.append(Object.assign(document.createElement("li"), {textContent: "nothing found"}));
});
