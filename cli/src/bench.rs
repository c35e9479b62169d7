//! `granary bench`: times the engine on this machine, beside LAMMPS if that is there.

mod beside;
mod lammps;

use std::path::{Path, PathBuf};
use std::sync::Barrier;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use granary_core::bench::{PackFile, Settings, Size, bench};
use granary_core::crew::Crew;
use granary_core::lanes::VectorWidth;
use granary_core::memory::spec::{ForceLaw, MemoryPoint, Precision, ShapeName};
use granary_core::memory::state::PackState;
use granary_core::stage::{Ensemble, Report, STATE, StageSpec, run as run_stage};
use granary_worker::machine;
use serde_json::{Value, json};

use crate::failure::Done;
use crate::{interrupt, output, table};
use lammps::Lammps;

/// Steps before the clock starts: the list is built and the caches are warm.
const WARM_UP: u64 = 50;

/// Time the engine on a packing at rest.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The experiment.
    #[arg(long, default_value = "memory", value_parser = ["memory"])]
    model: String,
    /// A pack file in the peers' format; without it, a loose pack is made first.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["shape", "grains"])]
    pack: Option<PathBuf>,
    /// Shape of the grains of a pack that is made.
    #[arg(long, value_enum, default_value_t = Shape::Tetrahedron)]
    shape: Shape,
    /// Grains of a pack that is made.
    #[arg(long, value_name = "N", default_value_t = 1024)]
    grains: u32,
    /// Replicas side by side: 1 or 8 in f64, 8 or 16 in f32.
    #[arg(long, value_name = "K", default_value_t = 16)]
    lanes: usize,
    /// Numbers.
    #[arg(long, value_enum, value_name = "P", default_value_t = Numbers::F32)]
    precision: Numbers,
    /// The tangential law; M2 with 100 slices.
    #[arg(long, value_enum, value_name = "LAW", default_value_t = Law::H, conflicts_with = "beside")]
    law: Law,
    /// Scenes stepped at once, each on a thread of its own.
    #[arg(long, value_name = "T", default_value_t = 1)]
    threads: usize,
    /// Threads that share the steps of each scene.
    #[arg(long, value_name = "T", default_value_t = 1, conflicts_with = "beside")]
    team: usize,
    /// Time step \[t_c\].
    #[arg(long, default_value_t = 0.1)]
    time_step: f64,
    /// How far beyond touching the list of candidates reaches \[R\]; the peers' benches use the default
    #[arg(long, default_value_t = 0.05)]
    skin: f64,
    /// Time the clock runs \[s\].
    #[arg(long, default_value_t = 2.0)]
    seconds: f64,
    /// Vector instructions: portable, avx2 or avx512; the widest by default.
    #[arg(long)]
    width: Option<String>,
    /// A LAMMPS program to time in turn with the engine, by CPU time: same pack, laws, skin and time step.
    #[arg(long, value_name = "LMP", conflicts_with = "threads")]
    beside: Option<PathBuf>,
    /// How often each of the two is timed.
    #[arg(long, value_name = "N", default_value_t = 5, requires = "beside")]
    #[arg(value_parser = clap::value_parser!(u8).range(1..=99))]
    repeats: u8,
    /// Print the figures as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Shape {
    Tetrahedron,
    Sphere,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Law {
    #[value(name = "H")]
    H,
    #[value(name = "M1")]
    M1,
    #[value(name = "M2")]
    M2,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Numbers {
    F32,
    F64,
}

/// What one thread did.
struct Timed {
    size: Size,
    steps: u64,
    wall: Duration,
    cpu: Duration,
}

/// A pack, how it is to be timed, and for how long.
struct Job {
    pack: PackFile,
    settings: Settings,
    limit: Duration,
}

/// Times and prints.
pub(crate) async fn run(args: &Args) -> anyhow::Result<Done> {
    let Some(program) = &args.beside else {
        let job = job(args)?;
        let timed = time_all(&job, args.threads.max(1), args.team)?;
        return print(&figures(&timed, &job), args.json);
    };
    // Before a pack is made: LAMMPS may be missing.
    let lammps = Lammps::find(program).await?;
    let job = job(args)?;
    tokio::select! {
        // The user's word reaches LAMMPS too, whose end then is no failure.
        biased;
        interrupted = interrupt::wait() => interrupted.map(|()| Done::Interrupted),
        figures = beside::time(&job, &lammps, args.repeats) => print(&figures?, args.json),
    }
}

/// What the arguments ask for.
fn job(args: &Args) -> anyhow::Result<Job> {
    let pack = match &args.pack {
        Some(path) => read(path)?,
        None => make(args.shape, args.grains)?,
    };
    let settings = Settings {
        lanes: args.lanes,
        precision: match args.precision {
            Numbers::F32 => Precision::F32,
            Numbers::F64 => Precision::F64,
        },
        force_law: match args.law {
            Law::H => ForceLaw::H,
            Law::M1 => ForceLaw::M1,
            Law::M2 => ForceLaw::M2,
        },
        time_step: args.time_step,
        skin: args.skin,
        width: width(args.width.as_deref())?,
    };
    let limit = Duration::try_from_secs_f64(args.seconds).context("--seconds is no duration")?;
    Ok(Job {
        pack,
        settings,
        limit,
    })
}

fn print(figures: &Value, as_json: bool) -> anyhow::Result<Done> {
    if as_json {
        output::json(figures)?;
        return Ok(Done::Complete);
    }
    let Some(figures) = figures.as_object() else {
        return Ok(Done::Complete);
    };
    let widest = figures.keys().map(String::len).max().unwrap_or_default();
    for (name, value) in figures {
        let value = match value {
            Value::Array(values) => {
                let values = values.iter().map(|value| table::parameter(Some(value)));
                values.collect::<Vec<_>>().join(" ")
            }
            value => table::parameter(Some(value)),
        };
        output::line(&format!("{name:widest$} {value}"))?;
    }
    Ok(Done::Complete)
}

fn width(name: Option<&str>) -> anyhow::Result<VectorWidth> {
    let Some(name) = name else {
        return Ok(VectorWidth::widest());
    };
    let mut available = VectorWidth::available().into_iter();
    let found = available.find(|width| width.name() == name);
    found.with_context(|| format!("this machine has no vectors called `{name}`"))
}

fn read(path: &Path) -> anyhow::Result<PackFile> {
    let place = path.display();
    let text = std::fs::read(path).with_context(|| format!("cannot read {place}"))?;
    serde_json::from_slice(&text).with_context(|| format!("{place} is not a pack file"))
}

/// A pack under the usual pressure, made in a hurry: one short compression cycle.
fn make(shape: Shape, grains: u32) -> anyhow::Result<PackFile> {
    eprintln!("making a pack of {grains} grains");
    let defaults = MemoryPoint::defaults("standard").context("there is a standard preset")?;
    let mut point = MemoryPoint::from_parameters(defaults).map_err(anyhow::Error::msg)?;
    point.grains = grains;
    point.preparation_cycles = 1;
    point.preparation_ramp = 1000.0;
    point.gas_time = 500.0;
    point.rest_kinetic_energy = 1e-7;
    point.shape = match shape {
        Shape::Tetrahedron => ShapeName::Tetrahedron,
        Shape::Sphere => ShapeName::Sphere,
    };
    let specs = [StageSpec::Pack(point.pack())];
    let ensemble = Ensemble {
        specs: &specs,
        input: &[],
        checkpoints: None,
    };
    let mut watch = |_: &Report<'_>| std::ops::ControlFlow::Continue(());
    let outcome = run_stage(&ensemble, &mut watch).pop();
    let mut outcome = outcome.context("the engine gave no answer")??;
    let state = outcome
        .artifacts
        .remove(STATE)
        .context("a pack has a state")?;
    let state = PackState::from_bytes(&state).map_err(anyhow::Error::msg)?;
    Ok(pack_file(&point, &state))
}

/// The pack in the peers' format.
fn pack_file(point: &MemoryPoint, state: &PackState) -> PackFile {
    let meters = |lengths: [f64; 3]| lengths.map(|length| length * point.radius);
    let positions: Vec<[f64; 3]> = state
        .poses
        .iter()
        .map(|pose| meters(pose.position))
        .collect();
    let turned = |[w, x, y, z]: [f64; 4]| [x, y, z, w];
    let quat = state.poses.iter().map(|pose| turned(pose.orientation));
    let walls = state.past.walls.map(|wall| wall * point.radius);
    let sphere = point.shape == ShapeName::Sphere;
    PackFile {
        kind: if sphere { "spheres" } else { "tetra" }.to_owned(),
        radius: point.radius,
        density: point.density,
        r#box: [
            [walls[0], walls[1]],
            [walls[2], walls[3]],
            [walls[4], walls[5]],
        ],
        overlap: point.overlap,
        quat: quat.collect(),
        com: positions.clone(),
        positions,
    }
}

/// Steps so many scenes at once, each by a team of its own.
fn time_all(job: &Job, threads: usize, team: usize) -> anyhow::Result<Vec<Timed>> {
    let start = Barrier::new(threads);
    let timed: Vec<Option<Timed>> = std::thread::scope(|scope| {
        let one = || time(job, team, &start);
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(one)).collect();
        let ended = running
            .into_iter()
            .map(|thread| thread.join().ok().flatten());
        ended.collect()
    });
    let timed: Option<Vec<Timed>> = timed.into_iter().collect();
    match timed {
        Some(timed) => Ok(timed),
        None => bail!(
            "{} lanes of {:?} on a pack of `{}` are not compiled",
            job.settings.lanes,
            job.settings.precision,
            job.pack.kind
        ),
    }
}

fn time(job: &Job, team: usize, start: &Barrier) -> Option<Timed> {
    let scene = bench(&job.pack, &job.settings);
    start.wait();
    let mut scene = scene?;
    let crew = Crew::new(team, machine::thread_cpu_time);
    let mut warm_up = 0..WARM_UP;
    crew.work(|| scene.run(&mut || warm_up.next().is_some()));
    let (wall, cpu) = (Instant::now(), machine::thread_cpu_time());
    let mut steps = 0;
    let mut in_time = || {
        let more = steps == 0 || wall.elapsed() < job.limit;
        steps += u64::from(more);
        more
    };
    let ((), help) = crew.work(|| scene.run(&mut in_time));
    Some(Timed {
        size: scene.size(),
        steps,
        wall: wall.elapsed(),
        cpu: machine::thread_cpu_time().saturating_sub(cpu) + help,
    })
}

/// Rates are sums over threads, by the wall clock; `cpu_share`, of a whole team, is below its size where the machine had other work.
fn figures(timed: &[Timed], job: &Job) -> Value {
    let (size, settings) = (timed[0].size, &job.settings);
    let steps_per_second: f64 = timed
        .iter()
        .map(|timed| timed.steps as f64 / timed.wall.as_secs_f64())
        .sum();
    let share = |timed: &Timed| timed.cpu.as_secs_f64() / timed.wall.as_secs_f64();
    let cpu_share = timed.iter().map(share).sum::<f64>() / timed.len() as f64;
    let replicas = size.lanes as f64;
    let grain_steps = steps_per_second * size.grains as f64 * replicas;
    let contact_updates = steps_per_second * size.contacts as f64 * replicas;
    json!({
        "grain_steps_per_second": grain_steps,
        "contact_updates_per_second": contact_updates,
        "nanoseconds_per_contact": timed.len() as f64 * 1e9 / contact_updates,
        "bytes_per_grain": size.bytes_per_grain,
        "bytes_per_contact": size.bytes_per_candidate,
        "grain_steps_per_cpu_second": grain_steps / cpu_share,
        "cpu_share": cpu_share,
        "grains": size.grains,
        "contacts": size.contacts,
        "lanes": size.lanes,
        "threads": timed.len(),
        "steps": timed.iter().map(|timed| timed.steps).sum::<u64>(),
        "list_renewals": size.renewals,
        "pack": job.pack.kind,
        "force_law": settings.force_law,
        "precision": settings.precision,
        "vectors": settings.width.name(),
        "skin": settings.skin,
        "time_step": settings.time_step,
    })
}
