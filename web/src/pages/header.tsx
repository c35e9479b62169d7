// The line above every page: its name, and the token.

import { useState } from "preact/hooks";
import { keepToken, token } from "../api/token";

export function Header() {
  return (
    <header class="top">
      <a class="name" href="#/">
        Granary
      </a>
      {token.value !== "" && (
        <button type="button" onClick={() => keepToken("")}>
          Forget token
        </button>
      )}
    </header>
  );
}

/** Asks for a token where the server wants one. */
export function TokenForm() {
  const [text, setText] = useState("");
  const submit = (event: Event) => {
    event.preventDefault();
    keepToken(text);
  };
  return (
    <form class="notice" onSubmit={submit}>
      <p>
        <strong>This server asks for a token.</strong>{" "}
        {token.value === "" ? "Paste one to read on." : "The one in use is not of this server."}
      </p>
      <label>
        Token{" "}
        <input
          type="password"
          autocomplete="off"
          required
          value={text}
          onInput={(event) => setText(event.currentTarget.value)}
        />
      </label>{" "}
      <button type="submit">Use it</button>
      <p class="quiet">
        It stays in this tab and goes nowhere but to this server. <code>granary token create --scope read</code> makes one.
      </p>
    </form>
  );
}
