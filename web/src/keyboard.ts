// Keys, and what the help says of them.
export interface Key {
  keys: string[];
  shown: string;
  does: string;
  run: (event: KeyboardEvent) => void;
}

/** Keys that an element under the focus needs for itself. */
function isTaken(event: KeyboardEvent): boolean {
  const target = event.target;
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement)
    return target.type !== 'checkbox' && (target.type !== 'range' || event.key.startsWith('Arrow') || event.key === 'Home' || event.key === 'End');
  if (target instanceof HTMLSelectElement) return true;
  return target instanceof HTMLButtonElement && (event.key === ' ' || event.key === 'Enter');
}

export function listen(keys: Key[], isOn: () => boolean): void {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || isTaken(event)) return;
    if (document.querySelector('dialog[open]') || !isOn()) return;
    const key = keys.find((each) => each.keys.includes(event.key));
    if (!key) return;
    event.preventDefault();
    key.run(event);
  });
}
