//! Files in and out of a run: the state that it starts from, and the checkpoints between.

use bytes::Bytes;
use granary_api::id::ArtifactHash;
use granary_core::stage::checkpoint_step;

use crate::backoff::persist;
use crate::execute::{Checkpoints, Inputs};
use crate::held::Held;
use crate::lease_client::{ArtifactClient, ClientError};

/// Fetches what the jobs of `held` start from.
///
/// A checkpoint that is missing, damaged or of another step is not worth a failure: the jobs then start from scratch.
///
/// # Errors
/// If the input is missing or damaged.
pub(crate) async fn fetch<C: ArtifactClient>(
    client: &C,
    held: &Held,
) -> Result<Inputs, ClientError> {
    let state = match held.jobs.first().and_then(|job| job.input) {
        Some(hash) => artifact(client, hash).await?.into(),
        None => Vec::new(),
    };
    let checkpoints = match fetch_checkpoints(client, held).await {
        Ok(checkpoints) => checkpoints,
        Err(error) => {
            tracing::warn!(error = %error, "checkpoint not readable, the job starts from scratch");
            None
        }
    };
    let checkpoints = match checkpoints {
        None => fetch_encodings(client, held).await?,
        some => some,
    };
    Ok(Inputs {
        specs: held.jobs.iter().map(|job| job.spec.clone()).collect(),
        state,
        checkpoints,
    })
}

/// The states that recalls go on from, if they do.
async fn fetch_encodings<C: ArtifactClient>(
    client: &C,
    held: &Held,
) -> Result<Option<Vec<Vec<u8>>>, ClientError> {
    if !held.jobs.iter().all(|job| job.spec.goes_on()) {
        return Ok(None);
    }
    let mut states = vec![];
    for hash in held.jobs.iter().filter_map(|job| job.input) {
        states.push(Vec::from(artifact(client, hash).await?));
    }
    Ok(Some(states))
}

/// The artifact `hash`; damage on the way is given a second try.
async fn artifact<C: ArtifactClient>(client: &C, hash: ArtifactHash) -> Result<Bytes, ClientError> {
    match persist(|| client.artifact_get(hash)).await {
        Err(ClientError::ArtifactDamaged(_)) => persist(|| client.artifact_get(hash)).await,
        answer => answer,
    }
}

/// A checkpoint for every job, all of one step; `None` if there is not one for each.
async fn fetch_checkpoints<C: ArtifactClient>(
    client: &C,
    held: &Held,
) -> Result<Option<Vec<Vec<u8>>>, ClientError> {
    let hashes: Option<Vec<ArtifactHash>> = held.jobs.iter().map(|job| job.checkpoint).collect();
    let mut checkpoints = vec![];
    for hash in hashes.into_iter().flatten() {
        checkpoints.push(Vec::from(artifact(client, hash).await?));
    }
    Ok(at_one_step(checkpoints))
}

/// `checkpoints`, if there are any, all can be read and all were taken at one step.
fn at_one_step(checkpoints: Vec<Vec<u8>>) -> Option<Vec<Vec<u8>>> {
    let first = checkpoint_step(checkpoints.first()?)?;
    let equal = |bytes: &Vec<u8>| checkpoint_step(bytes) == Some(first);
    checkpoints.iter().all(equal).then_some(checkpoints)
}

/// Stores the checkpoints of all jobs, then notes their names for the next heartbeat.
///
/// # Errors
/// If one cannot be stored; the names noted before stay valid.
pub(crate) async fn store<C: ArtifactClient>(
    client: &C,
    held: &Held,
    checkpoints: &Checkpoints,
) -> Result<(), ClientError> {
    let mut hashes = Vec::with_capacity(checkpoints.len());
    for bytes in checkpoints.iter() {
        let hash = ArtifactHash::of_bytes(bytes);
        client
            .artifact_put(hash, Bytes::copy_from_slice(bytes))
            .await?;
        hashes.push(hash);
    }
    held.note_checkpoints(&hashes);
    Ok(())
}
