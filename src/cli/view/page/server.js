// What the page and `pse view` say to each other. All paths are relative, so they keep the token of the address.

/** This page among those that are open. */
export const client = Math.random().toString(36).slice(2);

async function answer(response) {
  if (!response.ok) throw new Error((await response.text()) || response.statusText);
  return response;
}

export async function get(path, values = {}) {
  return answer(await fetch(`${path}?${new URLSearchParams(values)}`));
}

export async function post(path, values) {
  const body = JSON.stringify({ client, ...values });
  return answer(await fetch(path, { method: "POST", headers: { "content-type": "application/json" }, body }));
}

/** Hears what happens; `gone(true)` when the server cannot be reached, `gone(false)` when it is there again. */
export function hear(handlers, gone) {
  const source = new EventSource("events");
  source.onopen = () => gone(false);
  source.onerror = () => {
    gone(true);
    // A server that was there and refused is asked again too.
    if (source.readyState === EventSource.CLOSED) setTimeout(() => hear(handlers, gone), 1000);
  };
  for (const [name, handler] of Object.entries(handlers)) {
    source.addEventListener(name, (event) => handler(JSON.parse(event.data)));
  }
}
