// The page of Granary: a list of sweeps, and one sweep live.

import { render } from "preact";
import { Header } from "./pages/header";
import { SweepPage } from "./pages/sweep";
import { SweepsPage } from "./pages/sweeps";
import { route } from "./route";
import "uplot/dist/uPlot.min.css";
import "./style.css";

function Page() {
  const { sweep } = route.value;
  return (
    <>
      <Header />
      <main>{sweep ? <SweepPage key={sweep} id={sweep} /> : <SweepsPage />}</main>
    </>
  );
}

const place = document.getElementById("page");
if (place) render(<Page />, place);
