// Written by `npm run api` from the server's OpenAPI document; do not edit.

export interface paths {
    "/api/v1/artifacts/{hash}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One file, or the range of it that `Range` names. */
        get: operations["read_artifact"];
        /** Stores a file, streamed to disk and checked against the hash that it is sent under. */
        put: operations["store_artifact"];
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/figures": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The figures that there are. */
        get: operations["list_figures"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/figures/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The sweep behind one. */
        get: operations["read_figure"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/healthz": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** 200 if the database answers. */
        get: operations["is_healthy"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/jobs/{job}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Everything about one job. */
        get: operations["read_job"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/jobs/{job}/log": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** What happened to it, line by line. */
        get: operations["read_job_log"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/leases": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Gives a worker the jobs of one ensemble, or 204 if there were none for as long as it would wait. */
        post: operations["take_lease"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/leases/{lease}/complete": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Records the outcomes of leased jobs, all or none; 409 `lease_lost` if the lease of one is another.
         * @description 422 `result-mismatch` if an outcome does not have its `result_hash`: the server computes it again.
         */
        post: operations["complete_lease"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/leases/{lease}/fail": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Records why jobs cannot be finished. */
        post: operations["fail_lease"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/leases/{lease}/heartbeat": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** A sign of life, with progress; answers which jobs to drop. */
        post: operations["beat_lease"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/leases/{lease}/release": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Takes jobs back untouched, with their latest checkpoints. */
        post: operations["release_lease"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/metrics": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Counts as Prometheus reads them. */
        get: operations["read_metrics"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/models": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The experiments that sweeps can be made of. */
        get: operations["list_models"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/models/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One experiment. */
        get: operations["read_model"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/sweeps": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Sweeps, the latest first. */
        get: operations["list_sweeps"];
        put?: never;
        /** Submits a sweep: its spec as JSON, of the same schema as the TOML file. */
        post: operations["submit_sweep"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/sweeps/{sweep}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One sweep. */
        get: operations["read_sweep"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/sweeps/{sweep}/cancel": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** The sweep wants its jobs no more; what other sweeps want goes on. */
        post: operations["cancel_sweep"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/sweeps/{sweep}/events": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The events of a sweep from the first, or after `Last-Event-ID`, without end. */
        get: operations["follow_sweep"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/sweeps/{sweep}/pause": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** No more of its jobs are given to workers. */
        post: operations["pause_sweep"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/sweeps/{sweep}/points": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The points of a sweep. */
        get: operations["list_points"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/sweeps/{sweep}/resume": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** The sweep goes on after a pause or a cancel. */
        post: operations["resume_sweep"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/sweeps/{sweep}/retry": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Tries again what failed by no fault of its own. */
        post: operations["retry_sweep"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/sweeps/{sweep}/sets": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The sets of a sweep. */
        get: operations["list_sets"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/workers": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Every worker that was ever heard of. */
        get: operations["list_workers"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
}
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /** @description How accurate a sweep's results must be, and what its pilot has found. */
        Accuracy: {
            choice?: components["schemas"]["Choice"] | null;
            /** @description The study that decides, a sweep like any other. */
            pilot: components["schemas"]["SweepId"];
            /** @description The largest error of each result; a share of it where its `{name}_deviation` is one. */
            targets: {
                [key: string]: number;
            };
        };
        /** @description One worker's try at a job. */
        Attempt: {
            /**
             * Format: int64
             * @description 1, 2, …
             */
            attempt: number;
            /** @description More about the ending. */
            detail?: string | null;
            /** @description RFC 3339; none while it runs. */
            ended_at?: string | null;
            /** @description `done`, `failed`, `lost`, `released` or `cancelled`; none while it runs. */
            ending?: string | null;
            /** @description The lease it ran under. */
            lease: components["schemas"]["LeaseId"];
            /** @description RFC 3339. */
            started_at: string;
            /** @description Who tried. */
            worker: components["schemas"]["WorkerId"];
        };
        /** @description The settings that a pilot has chosen, and why. */
        Choice: {
            /** @description What the pilot says of them, one row for each scene that it looked at: errors with their bounds, and cost. */
            evidence: components["schemas"]["SetRow"][];
            /**
             * Format: double
             * @description Core-seconds that the pilot took, packings and reference included.
             */
            pilot_core_seconds: number;
            /** @description Why it is the reference, if it is. */
            reason?: string | null;
            /**
             * Format: double
             * @description Core-seconds of a packing's runs in these settings over those of the reference: what was saved.
             */
            relative_cost?: number | null;
            /** @description In words, such as `ramp 4500, drag 0.01`. */
            setting: string;
            /** @description The parameters that were chosen; every point has them. */
            values: Record<string, unknown>;
        };
        /** @description `POST /leases/{lease}/complete`: outcomes of some or all jobs of the lease. */
        Completion: {
            /** @description One per finished job; all are recorded, or none. */
            outcomes: components["schemas"]["JobOutcome"][];
        };
        /** @description A word that was taken for another. */
        Confused: {
            /**
             * Format: int32
             * @description The word that the recalled signal was taken for.
             */
            taken_for: number;
            /**
             * Format: int32
             * @description By how many trainings of the classifier.
             */
            trainings: number;
            /**
             * Format: int32
             * @description The word that was stored.
             */
            word: number;
        };
        /** @description One event of `GET /sweeps/{id}/events`. */
        Event: {
            /** @description RFC 3339. */
            at: string;
            /** @description What happened. */
            data: Record<string, unknown>;
            /**
             * Format: int64
             * @description Rises within a sweep; `Last-Event-ID` resumes after it.
             */
            id: number;
            /** @description `point`, `state` or `diverged`; `progress` is never stored. */
            kind: string;
        };
        /** @description Why a job failed. */
        Failure: {
            /** @description The failed job that this one needs. */
            job?: string | null;
            /** @description What stopped the run: `unstable`, `non_finite`, `overlap` or `not_at_rest`. */
            kind?: string | null;
            /** @description The whole story in one sentence. */
            message: string;
            /** @description `stopped` (physics, final), `input` (machine), `needs` (what it needs has failed) or `poisoned`. */
            reason: string;
            /** @description What to change. */
            remedy?: string | null;
            /**
             * Format: int64
             * @description The step at which it stopped.
             */
            step?: number | null;
        };
        /** @description `POST /leases/{lease}/fail`: some jobs cannot be finished. */
        FailureReport: {
            /** @description One per failed job. */
            failures: components["schemas"]["JobFailure"][];
        };
        /** @description A figure or table. */
        Figure: {
            /** @description The experiment. */
            model: string;
            /** @description What commands and paths call it. */
            name: string;
            /** @description Its sizes, from a draft for a laptop to the paper's own. */
            presets: string[];
            /** @description What it shows, in a few words. */
            shows: string;
        };
        /** @description The sweep behind a figure. */
        FigureSpec: {
            /** @description The figure. */
            figure: components["schemas"]["Figure"];
            /** @description The spec, as `POST /sweeps` takes it. */
            spec: Record<string, unknown>;
            /** @description The same as TOML, with its comments. */
            toml: string;
        };
        /** @description `POST /leases/{lease}/heartbeat`: I live, and this is how far I am. */
        Heartbeat: {
            /** @description Progress of each job still held. */
            jobs: components["schemas"]["JobProgress"][];
        };
        /** @description The answer to a heartbeat. */
        HeartbeatReply: {
            /** @description Jobs of this lease that the worker should drop: cancelled, or no longer under this lease. */
            stop: string[];
        };
        /** @description How the jobs of a sweep relate to what the database already holds. */
        JobCounts: {
            /**
             * Format: int64
             * @description Already done, for this sweep or another.
             */
            done: number;
            /**
             * Format: int64
             * @description Not known before, and in no archive.
             */
            new: number;
            /**
             * Format: int64
             * @description Known but not done: queued, running, failed or cancelled before.
             */
            shared: number;
            /**
             * Format: int64
             * @description Jobs in all.
             */
            total: number;
        };
        /** @description `GET /jobs/{id}`. */
        JobDetail: Record<string, unknown> & {
            /** @description Files by name. */
            artifacts: {
                [key: string]: string;
            };
            /** @description Every try. */
            attempts: components["schemas"]["Attempt"][];
            /** @description Other results that were reported for the same stage: a bug, ours or a machine's. */
            diverged: string[];
            failure?: components["schemas"]["Failure"] | null;
            /**
             * Format: int64
             * @description Faults of machines while running it.
             */
            faults: number;
            /** @description The job. */
            job: string;
            /**
             * Format: int64
             * @description Workers lost while running it.
             */
            losses: number;
            /** @description The job whose state it starts from. */
            needs?: string | null;
            progress?: components["schemas"]["Progress"] | null;
            provenance?: components["schemas"]["Provenance"] | null;
            /** @description Hash of the outcome. */
            result_hash?: string | null;
            /** @description Scalars by name. */
            results: {
                [key: string]: components["schemas"]["Scalar"];
            };
            /** @description Where it stands. */
            state: components["schemas"]["JobState"];
            /** @description The sweeps that want it. */
            sweeps: components["schemas"]["SweepId"][];
            /** @description What a reader of the numbers should know. */
            warnings: string[];
        };
        /**
         * @description Why one job failed.
         *
         *     `stopped` is final (the physics broke down); `input` is a fault of the machine and is tried again.
         */
        JobFailure: {
            /** @description Why. */
            failure: Record<string, unknown>;
            /** @description The job. */
            job: string;
        };
        /** @description What one job yielded; its artifacts are already stored. */
        JobOutcome: {
            /** @description Files by name. */
            artifacts: {
                [key: string]: string;
            };
            /** @description The job. */
            job: string;
            /** @description Where and how it was computed. */
            provenance: components["schemas"]["Provenance"];
            /** @description Why a scalar is `null`, in one word, by the scalar's name. */
            reasons?: {
                [key: string]: string;
            };
            /** @description The hash of results, reasons, artifacts, warnings and steps, as [`granary_core::stage::Outcome::hash`] makes it. */
            result_hash: string;
            /** @description Scalars by name. */
            results: {
                [key: string]: number | null;
            };
            /** @description What a reader of the numbers should know. */
            warnings: string[];
        };
        /** @description How far one job is. */
        JobProgress: {
            /** @description The latest checkpoint, already stored as an artifact. */
            checkpoint?: string | null;
            /** @description The job. */
            job: string;
            /**
             * Format: int64
             * @description Steps done.
             */
            step: number;
            /**
             * Format: int64
             * @description Steps in all.
             */
            steps: number;
        };
        /**
         * @description Where a job stands; it is in exactly one state.
         * @enum {string}
         */
        JobState: "blocked" | "ready" | "leased" | "done" | "failed" | "poisoned" | "cancelled";
        /** @description The jobs of one ensemble, under one lease. */
        LeaseGrant: {
            /**
             * Format: double
             * @description How often to send a heartbeat \[s\].
             */
            heartbeat_s: number;
            /** @description The jobs, all with the same ensemble key and, if they have checkpoints, at the same step. */
            jobs: components["schemas"]["LeasedJob"][];
            /** @description The lease; `jobs` is never empty. */
            lease: components["schemas"]["LeaseId"];
        };
        /**
         * Format: uuid
         * @description One worker's hold on the jobs of one ensemble; the fence against late answers.
         */
        LeaseId: string;
        /** @description `POST /leases`: what the worker can do. */
        LeaseRequest: {
            /** @description Release of the worker's program. */
            engine_version: string;
            /**
             * Format: int64
             * @description Memory that an ensemble may take \[bytes\].
             */
            memory_bytes: number;
            /**
             * Format: int32
             * @description The physics version of its engine; jobs of another are never given to it.
             */
            physics_version: number;
            /**
             * Format: double
             * @description How long to wait for work before answering with none \[s\], at most 30.
             */
            wait_s: number;
            /** @description Who asks. */
            worker: components["schemas"]["WorkerId"];
        };
        /** @description One job of a lease. */
        LeasedJob: Record<string, unknown> & {
            /** @description The latest checkpoint of an earlier attempt. */
            checkpoint?: string | null;
            /** @description The state that it starts from; none for `pack`. The same for every job of a lease, but for recalls that go on from encodings. */
            input?: string | null;
            /** @description The job. */
            job: string;
        };
        /** @description One line of `GET /jobs/{id}/log`. */
        LogLine: {
            /** @description RFC 3339. */
            at: string;
            /** @description What happened. */
            message: string;
        };
        /** @description What a study found of a preset. */
        Measured: {
            /**
             * Format: int64
             * @description Packings.
             */
            n: number;
            /** @description How what was recalled became a signal, of a model that has several ways. */
            processing?: string | null;
            /** @description Deviations from the study's reference, their uncertainty and the cost, by name. */
            results: {
                [key: string]: number | null;
            };
            /** @description On which scene. */
            scene: string;
        };
        /** @description One mistake in a request. */
        Mistake: {
            /** @description The value, the rule, and what was perhaps meant. */
            detail: string;
            /** @description Where, as a JSON pointer (RFC 6901). */
            pointer: string;
        };
        /** @description An experiment and its parameters. */
        Model: {
            /** @description The name in a sweep's `model`. */
            name: string;
            /** @description Every parameter, as the properties of a JSON Schema with `x-symbol`, `x-unit` and `x-section`. */
            parameters: Record<string, unknown>;
            /** @description Named choices of numerics. */
            presets: components["schemas"]["Preset"][];
            /** @description Reductions that it allows, the usual chain first. */
            reductions: unknown[];
            /** @description Every result, as the properties of a JSON Schema with `x-symbol` and `x-unit`. */
            results: Record<string, unknown>;
            /** @description What it is, in one sentence. */
            sentence: string;
        };
        /** @description Part of a list. */
        Page_Figure: {
            /** @description The rows. */
            items: {
                /** @description The experiment. */
                model: string;
                /** @description What commands and paths call it. */
                name: string;
                /** @description Its sizes, from a draft for a laptop to the paper's own. */
                presets: string[];
                /** @description What it shows, in a few words. */
                shows: string;
            }[];
            /** @description What `cursor` asks for the rows after these; none at the end. */
            next?: string | null;
            /**
             * Format: int64
             * @description Rows in all, on every page, after `where`.
             */
            total: number;
        };
        /** @description Part of a list. */
        Page_LogLine: {
            /** @description The rows. */
            items: {
                /** @description RFC 3339. */
                at: string;
                /** @description What happened. */
                message: string;
            }[];
            /** @description What `cursor` asks for the rows after these; none at the end. */
            next?: string | null;
            /**
             * Format: int64
             * @description Rows in all, on every page, after `where`.
             */
            total: number;
        };
        /** @description Part of a list. */
        Page_Model: {
            /** @description The rows. */
            items: {
                /** @description The name in a sweep's `model`. */
                name: string;
                /** @description Every parameter, as the properties of a JSON Schema with `x-symbol`, `x-unit` and `x-section`. */
                parameters: Record<string, unknown>;
                /** @description Named choices of numerics. */
                presets: components["schemas"]["Preset"][];
                /** @description Reductions that it allows, the usual chain first. */
                reductions: unknown[];
                /** @description Every result, as the properties of a JSON Schema with `x-symbol` and `x-unit`. */
                results: Record<string, unknown>;
                /** @description What it is, in one sentence. */
                sentence: string;
            }[];
            /** @description What `cursor` asks for the rows after these; none at the end. */
            next?: string | null;
            /**
             * Format: int64
             * @description Rows in all, on every page, after `where`.
             */
            total: number;
        };
        /** @description Part of a list. */
        Page_PointRow: {
            /** @description The rows. */
            items: {
                failure?: components["schemas"]["Failure"] | null;
                /** @description The job that computes it. */
                job: string;
                /** @description The parameters that vary in the sweep. */
                parameters: Record<string, unknown>;
                /**
                 * Format: int64
                 * @description Its number, from 0, in the order of the spec.
                 */
                point: number;
                progress?: components["schemas"]["Progress"] | null;
                /** @description Hash of the outcome. */
                result_hash?: string | null;
                /** @description Scalars by name, and beside one that is `null` the word why, as `{name}_reason`; empty until it is done. */
                results: {
                    [key: string]: components["schemas"]["Scalar"];
                };
                /** @description Where its job stands. */
                state: components["schemas"]["JobState"];
                /** @description What a reader of the numbers should know. */
                warnings: string[];
            }[];
            /** @description What `cursor` asks for the rows after these; none at the end. */
            next?: string | null;
            /**
             * Format: int64
             * @description Rows in all, on every page, after `where`.
             */
            total: number;
        };
        /** @description Part of a list. */
        Page_SetRow: {
            /** @description The rows. */
            items: {
                /** @description Words that a classifier took for others, those that most trainings confuse first. */
                confused?: components["schemas"]["Confused"][];
                /**
                 * @description Why a number is `null`; once nothing is still to come, also why `n` is less than `of`.
                 *
                 *     While `provisional`, it speaks of the members that count so far, never of those to come.
                 */
                missing_reason?: string | null;
                /**
                 * Format: int64
                 * @description Members that count so far.
                 */
                n: number;
                /**
                 * Format: int64
                 * @description Members in all.
                 */
                of: number;
                /** @description The parameters that vary in the sweep and that it was not taken over. */
                parameters: Record<string, unknown>;
                /** @description How signals were processed. */
                processing?: string | null;
                /** @description Whether members are still to come. */
                provisional: boolean;
                /** @description The reduction. */
                reduce: string;
                /** @description Numbers by name; `null` where a number has no meaning (yet). */
                results: {
                    [key: string]: number | null;
                };
                /**
                 * Format: int64
                 * @description Its number, from 0, in the order of the reductions.
                 */
                set: number;
                /** @description A study's setting in words, such as `time_step 0.5`. */
                setting?: string | null;
                /** @description How much of Eq. (4) a fit's strengths determine: `exponential`, `step`, `straight`, `constant` or `too_few_points`. */
                shape?: string | null;
                /**
                 * @description What a study says of a setting: `reference`, `front` (no other is cheaper and at least as accurate), `beaten` or
                 *     `incomplete` (a packing without a result).
                 */
                verdict?: string | null;
                /** @description What a reader of the numbers should know: that signals are noisy. */
                warning?: string | null;
            }[];
            /** @description What `cursor` asks for the rows after these; none at the end. */
            next?: string | null;
            /**
             * Format: int64
             * @description Rows in all, on every page, after `where`.
             */
            total: number;
        };
        /** @description Part of a list. */
        Page_Sweep: {
            /** @description The rows. */
            items: {
                accuracy?: components["schemas"]["Accuracy"] | null;
                /** @description The parameters that vary. */
                axes: string[];
                /** @description RFC 3339. */
                created_at: string;
                /**
                 * Format: double
                 * @description Seconds to the end, at the rate of the jobs that were finished last and the present number of busy engine threads.
                 */
                eta_s?: number | null;
                /** @description The experiment. */
                model: string;
                /** @description Its name. */
                name: string;
                /** @description Its points by state. */
                points: components["schemas"]["PointCounts"];
                /**
                 * Format: double
                 * @description Points finished per second over the last minutes, since this server started.
                 */
                points_per_second?: number | null;
                /** @description Named choice of numerics. */
                preset: string;
                /**
                 * Format: int64
                 * @description Sweeps of higher priority are served first.
                 */
                priority: number;
                /** @description The spec as submitted; only when one sweep is asked for. */
                spec?: Record<string, unknown> | null;
                /** @description Where it stands. */
                state: components["schemas"]["SweepState"];
                /** @description The sweep. */
                sweep: components["schemas"]["SweepId"];
                /** @description What is allowed but unwise. */
                warnings: string[];
            }[];
            /** @description What `cursor` asks for the rows after these; none at the end. */
            next?: string | null;
            /**
             * Format: int64
             * @description Rows in all, on every page, after `where`.
             */
            total: number;
        };
        /** @description Part of a list. */
        Page_WorkerRow: {
            /** @description The rows. */
            items: {
                /**
                 * Format: int64
                 * @description Jobs that it has finished.
                 */
                done: number;
                /** @description Release of its program. */
                engine_version: string;
                /** @description RFC 3339. */
                first_seen: string;
                /** @description RFC 3339. */
                last_seen: string;
                /**
                 * Format: int64
                 * @description Jobs that it holds.
                 */
                leased: number;
                /**
                 * Format: int64
                 * @description Memory that its ensembles may take \[bytes\].
                 */
                memory_bytes: number;
                /**
                 * Format: int32
                 * @description Physics version of its engine.
                 */
                physics_version: number;
                /** @description `working`, `idle` or `silent` (not heard of for a minute). */
                state: string;
                /** @description Its name. */
                worker: components["schemas"]["WorkerId"];
            }[];
            /** @description What `cursor` asks for the rows after these; none at the end. */
            next?: string | null;
            /**
             * Format: int64
             * @description Rows in all, on every page, after `where`.
             */
            total: number;
        };
        /** @description How many points are in which state. */
        PointCounts: {
            /**
             * Format: int64
             * @description Wanted no more.
             */
            cancelled: number;
            /**
             * Format: int64
             * @description With results.
             */
            done: number;
            /**
             * Format: int64
             * @description Failed or poisoned, each with its reason.
             */
            failed: number;
            /**
             * Format: int64
             * @description At a worker.
             */
            running: number;
            /**
             * Format: int64
             * @description All.
             */
            total: number;
            /**
             * Format: int64
             * @description Blocked or ready.
             */
            waiting: number;
        };
        /** @description One row of a sweep's table. */
        PointRow: {
            failure?: components["schemas"]["Failure"] | null;
            /** @description The job that computes it. */
            job: string;
            /** @description The parameters that vary in the sweep. */
            parameters: Record<string, unknown>;
            /**
             * Format: int64
             * @description Its number, from 0, in the order of the spec.
             */
            point: number;
            progress?: components["schemas"]["Progress"] | null;
            /** @description Hash of the outcome. */
            result_hash?: string | null;
            /** @description Scalars by name, and beside one that is `null` the word why, as `{name}_reason`; empty until it is done. */
            results: {
                [key: string]: components["schemas"]["Scalar"];
            };
            /** @description Where its job stands. */
            state: components["schemas"]["JobState"];
            /** @description What a reader of the numbers should know. */
            warnings: string[];
        };
        /** @description Predicted cost. */
        Prediction: {
            /** @description `measured` (rates of past outcomes here), `default` (no such outcome yet) or `mixed`. */
            basis: string;
            /**
             * Format: double
             * @description Time on one core \[s\].
             */
            core_seconds: number;
            /**
             * Format: int64
             * @description Memory of the largest ensemble \[bytes\].
             */
            memory_bytes: number;
            /**
             * Format: int64
             * @description Files that will be kept \[bytes\].
             */
            storage_bytes: number;
        };
        /** @description A named choice of numerics. */
        Preset: {
            /** @description What it costs in accuracy and in time, as studies found on scenes that they name. */
            measured: components["schemas"]["Measured"][];
            /** @description The name in a sweep's `preset`. */
            name: string;
            /** @description What it is for. */
            sentence: string;
            /** @description The parameters that it sets. */
            values: Record<string, unknown>;
        };
        /** @description `application/problem+json`. */
        Problem: {
            /** @description What happened this time. */
            detail?: string | null;
            /** @description One entry per mistake. */
            errors?: components["schemas"]["Mistake"][];
            /**
             * Format: int32
             * @description The HTTP status.
             */
            status: number;
            /** @description The same for people. */
            title: string;
            /** @description Which rule was broken, as a path: `/problems/invalid-sweep`. */
            type: string;
        };
        /** @description How far a running job is. */
        Progress: {
            /** @description The worker's last word, RFC 3339. */
            last_heartbeat: string;
            /**
             * Format: int64
             * @description Steps done.
             */
            step: number;
            /**
             * Format: int64
             * @description Steps in all.
             */
            steps: number;
            /** @description Who runs it. */
            worker: components["schemas"]["WorkerId"];
        };
        /** @description Where and how an outcome was computed: kept beside it, never part of its hash. */
        Provenance: {
            /**
             * Format: double
             * @description CPU time of the ensemble's thread \[s\].
             */
            cpu_s: number;
            /** @description Release of the program. */
            engine_version: string;
            /**
             * Format: int32
             * @description Jobs side by side in the ensemble.
             */
            lanes: number;
            /**
             * Format: int32
             * @description Physics version.
             */
            physics_version: number;
            /**
             * Format: int64
             * @description Time steps of this job.
             */
            steps: number;
            /** @description Target and vector width, such as `x86_64-linux avx512`. */
            target: string;
            /**
             * Format: double
             * @description Wall time of the ensemble \[s\], from this attempt's start.
             */
            wall_s: number;
            /** @description Who computed it. */
            worker: components["schemas"]["WorkerId"];
        };
        /** @description `POST /leases/{lease}/release`: hands jobs back untouched, with the latest checkpoint of each. */
        Release: {
            /** @description The jobs handed back, with their progress. */
            jobs: components["schemas"]["JobProgress"][];
        };
        /** @description One result. */
        Scalar: number | string | null;
        /** @description One row of a reduction: points, or other sets, taken together. */
        SetRow: {
            /** @description Words that a classifier took for others, those that most trainings confuse first. */
            confused?: components["schemas"]["Confused"][];
            /**
             * @description Why a number is `null`; once nothing is still to come, also why `n` is less than `of`.
             *
             *     While `provisional`, it speaks of the members that count so far, never of those to come.
             */
            missing_reason?: string | null;
            /**
             * Format: int64
             * @description Members that count so far.
             */
            n: number;
            /**
             * Format: int64
             * @description Members in all.
             */
            of: number;
            /** @description The parameters that vary in the sweep and that it was not taken over. */
            parameters: Record<string, unknown>;
            /** @description How signals were processed. */
            processing?: string | null;
            /** @description Whether members are still to come. */
            provisional: boolean;
            /** @description The reduction. */
            reduce: string;
            /** @description Numbers by name; `null` where a number has no meaning (yet). */
            results: {
                [key: string]: number | null;
            };
            /**
             * Format: int64
             * @description Its number, from 0, in the order of the reductions.
             */
            set: number;
            /** @description A study's setting in words, such as `time_step 0.5`. */
            setting?: string | null;
            /** @description How much of Eq. (4) a fit's strengths determine: `exponential`, `step`, `straight`, `constant` or `too_few_points`. */
            shape?: string | null;
            /**
             * @description What a study says of a setting: `reference`, `front` (no other is cheaper and at least as accurate), `beaten` or
             *     `incomplete` (a packing without a result).
             */
            verdict?: string | null;
            /** @description What a reader of the numbers should know: that signals are noisy. */
            warning?: string | null;
        };
        /** @description The answer to `POST …/cancel`, `/pause`, `/resume` and `/retry`. */
        Steered: {
            /**
             * Format: int64
             * @description Jobs that were moved.
             */
            jobs: number;
            /** @description Where the sweep stands now. */
            state: components["schemas"]["SweepState"];
        };
        /** @description The answer to `POST /sweeps`. */
        Submitted: {
            /** @description Whether the sweep is new; an identical one is found again. */
            created: boolean;
            /** @description Whether this was a dry run: nothing is queued. */
            dry_run: boolean;
            /** @description The jobs it wants, helpers and preparation included. */
            jobs: components["schemas"]["JobCounts"];
            /** @description The above for people: `64 of 64 already done`. */
            message: string;
            /**
             * Format: int64
             * @description Rows of its table.
             */
            points: number;
            /**
             * Format: int64
             * @description Rows that are already done.
             */
            points_done: number;
            /** @description What the jobs that are not done will take. */
            predicted: components["schemas"]["Prediction"];
            sweep?: components["schemas"]["SweepId"] | null;
            /** @description What is allowed but unwise. */
            warnings: string[];
        };
        /** @description One row of `GET /sweeps`, and `GET /sweeps/{id}`. */
        Sweep: {
            accuracy?: components["schemas"]["Accuracy"] | null;
            /** @description The parameters that vary. */
            axes: string[];
            /** @description RFC 3339. */
            created_at: string;
            /**
             * Format: double
             * @description Seconds to the end, at the rate of the jobs that were finished last and the present number of busy engine threads.
             */
            eta_s?: number | null;
            /** @description The experiment. */
            model: string;
            /** @description Its name. */
            name: string;
            /** @description Its points by state. */
            points: components["schemas"]["PointCounts"];
            /**
             * Format: double
             * @description Points finished per second over the last minutes, since this server started.
             */
            points_per_second?: number | null;
            /** @description Named choice of numerics. */
            preset: string;
            /**
             * Format: int64
             * @description Sweeps of higher priority are served first.
             */
            priority: number;
            /** @description The spec as submitted; only when one sweep is asked for. */
            spec?: Record<string, unknown> | null;
            /** @description Where it stands. */
            state: components["schemas"]["SweepState"];
            /** @description The sweep. */
            sweep: components["schemas"]["SweepId"];
            /** @description What is allowed but unwise. */
            warnings: string[];
        };
        /**
         * Format: uuid
         * @description A submitted sweep.
         */
        SweepId: string;
        /**
         * @description Where a sweep stands.
         * @enum {string}
         */
        SweepState: "active" | "paused" | "cancelled" | "finished";
        /** @description What a worker calls itself: host, process and a counter, at most 200 characters. */
        WorkerId: string;
        /** @description One row of `GET /workers`. */
        WorkerRow: {
            /**
             * Format: int64
             * @description Jobs that it has finished.
             */
            done: number;
            /** @description Release of its program. */
            engine_version: string;
            /** @description RFC 3339. */
            first_seen: string;
            /** @description RFC 3339. */
            last_seen: string;
            /**
             * Format: int64
             * @description Jobs that it holds.
             */
            leased: number;
            /**
             * Format: int64
             * @description Memory that its ensembles may take \[bytes\].
             */
            memory_bytes: number;
            /**
             * Format: int32
             * @description Physics version of its engine.
             */
            physics_version: number;
            /** @description `working`, `idle` or `silent` (not heard of for a minute). */
            state: string;
            /** @description Its name. */
            worker: components["schemas"]["WorkerId"];
        };
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type $defs = Record<string, never>;
export interface operations {
    read_artifact: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                hash: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": unknown;
                };
            };
            206: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            304: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            416: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    store_artifact: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                hash: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/octet-stream": number[];
            };
        };
        responses: {
            /** @description known */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_figures: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_Figure"];
                };
            };
        };
    };
    read_figure: {
        parameters: {
            query?: {
                /** @description A preset of its model; `draft` without. */
                preset?: string;
                /** @description Packings of each combination, 1 to 1,000; one without. */
                packings?: number;
            };
            header?: never;
            path: {
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["FigureSpec"];
                };
            };
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
        };
    };
    is_healthy: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
        };
    };
    read_job: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                job: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobDetail"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    read_job_log: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                job: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_LogLine"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    take_lease: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["LeaseRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["LeaseGrant"];
                };
            };
            /** @description no work */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
        };
    };
    complete_lease: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                lease: components["schemas"]["LeaseId"];
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Completion"];
            };
        };
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    fail_lease: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                lease: components["schemas"]["LeaseId"];
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["FailureReport"];
            };
        };
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    beat_lease: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                lease: components["schemas"]["LeaseId"];
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Heartbeat"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HeartbeatReply"];
                };
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    release_lease: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                lease: components["schemas"]["LeaseId"];
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Release"];
            };
        };
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    read_metrics: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/plain": unknown;
                };
            };
        };
    };
    list_models: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_Model"];
                };
            };
        };
    };
    read_model: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Model"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
        };
    };
    list_sweeps: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The `next` of the page before. */
                cursor: components["schemas"]["SweepId"] | null;
                /** @description Sweeps of a page, 1 to 1,000. */
                limit: number | null;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_Sweep"];
                };
            };
        };
    };
    submit_sweep: {
        parameters: {
            query?: never;
            header?: {
                "Idempotency-Key"?: string | null;
            };
            path: {
                /** @description Count and predict, queue nothing. */
                dry_run: boolean;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": Record<string, unknown>;
            };
        };
        responses: {
            /** @description known, or a dry run */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Submitted"];
                };
            };
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Submitted"];
                };
            };
            /** @description every mistake; nothing queued */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    read_sweep: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                sweep: components["schemas"]["SweepId"];
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Sweep"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    cancel_sweep: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                sweep: components["schemas"]["SweepId"];
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Steered"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    follow_sweep: {
        parameters: {
            query?: never;
            header?: {
                "Last-Event-ID"?: number | null;
            };
            path: {
                sweep: components["schemas"]["SweepId"];
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/event-stream": components["schemas"]["Event"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    pause_sweep: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                sweep: components["schemas"]["SweepId"];
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Steered"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_points: {
        parameters: {
            query?: {
                /** @description `COLUMN`, one of `= != < <= > >=`, and a value; rows must meet all of them, 20 at most. */
                where?: string[];
                /** @description The column to order by, descending after a `-`. */
                sort?: string;
                /** @description The columns to show, separated by commas. */
                columns?: string;
                /** @description The `next` of the page before. */
                cursor?: string;
                /** @description Rows of a page, 1 to 10,000. */
                limit?: number;
                /** @description `json` or `csv`; the Accept header counts if this is absent. */
                format?: string;
            };
            header?: never;
            path: {
                sweep: components["schemas"]["SweepId"];
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_PointRow"];
                };
            };
            304: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    resume_sweep: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                sweep: components["schemas"]["SweepId"];
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Steered"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    retry_sweep: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                sweep: components["schemas"]["SweepId"];
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Steered"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_sets: {
        parameters: {
            query?: {
                /** @description `COLUMN`, one of `= != < <= > >=`, and a value; rows must meet all of them, 20 at most. */
                where?: string[];
                /** @description The column to order by, descending after a `-`. */
                sort?: string;
                /** @description The columns to show, separated by commas. */
                columns?: string;
                /** @description The `next` of the page before. */
                cursor?: string;
                /** @description Rows of a page, 1 to 10,000. */
                limit?: number;
                /** @description `json` or `csv`; the Accept header counts if this is absent. */
                format?: string;
            };
            header?: never;
            path: {
                sweep: components["schemas"]["SweepId"];
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_SetRow"];
                };
            };
            304: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_workers: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_WorkerRow"];
                };
            };
        };
    };
}
