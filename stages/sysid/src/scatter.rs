//! How repeats differ, and what that leaves of a strike's evidence.
//!
//! A strike's residual is r = G·b + ε: b the scatter of its launch (speed, angle), the error of its clock and of its
//! resting place, ε the camera's noise. With b ~ N(0, P), Σ⁻¹ = (I − G·C·Gᵀ)/σ², C = (GᵀG + σ²P⁻¹)⁻¹.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use world::Scatter;

/// Speed, angle, clock, resting x, resting y.
pub(crate) const NUISANCES: usize = 5;

/// Standard deviations of a strike's nuisances and of the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    /// Relative speed, angle (rad), clock (s), resting x and y (m).
    pub(crate) nuisance: [f64; NUISANCES],
    /// Of a centroid's coordinate, in m.
    pub(crate) camera: f64,
}

impl Spread {
    /// Before anything is estimated: 1 % of speed, 0.5°, half a frame, and a resting place averaged over ten frames.
    pub(crate) fn initial(camera_noise: f64, frame: f64) -> Self {
        let rest = camera_noise / 10f64.sqrt();
        Self {
            nuisance: [0.01, 0.5f64.to_radians(), 0.5 * frame, rest, rest],
            camera: camera_noise,
        }
    }

    /// What goes into `world.toml`.
    pub(crate) fn scatter(&self) -> Scatter {
        Scatter {
            speed: self.nuisance[0],
            angle: self.nuisance[1],
            camera: self.camera,
        }
    }
}

/// One strike: residual, its derivatives by the nuisances, and C.
pub(crate) struct Evidence {
    pub(crate) residual: DVector<f64>,
    nuisances: DMatrix<f64>,
    posterior: SMatrix<f64, NUISANCES, NUISANCES>,
    camera: f64,
}

impl Evidence {
    /// `nuisances`: one column for each, a row for each coordinate of the residual.
    pub(crate) fn new(residual: DVector<f64>, nuisances: DMatrix<f64>, spread: &Spread) -> Self {
        let variance = spread.camera * spread.camera;
        let gram = nuisances.tr_mul(&nuisances);
        let mut precision = SMatrix::<f64, NUISANCES, NUISANCES>::from_fn(|i, j| gram[(i, j)]);
        for (i, sd) in spread.nuisance.iter().enumerate() {
            precision[(i, i)] += variance / (sd * sd).max(1e-18);
        }
        let posterior = precision
            .cholesky()
            .map_or_else(SMatrix::zeros, |c| c.inverse());
        Self {
            residual,
            nuisances,
            posterior,
            camera: spread.camera,
        }
    }

    /// Σ⁻¹·m for a matrix of as many rows as the residual.
    pub(crate) fn weigh(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        let projected = self.nuisances.tr_mul(m);
        let posterior = DMatrix::from_fn(NUISANCES, NUISANCES, |i, j| self.posterior[(i, j)]);
        (m - &self.nuisances * (posterior * projected)) / (self.camera * self.camera)
    }

    /// rᵀ·Σ⁻¹·r.
    pub(crate) fn distance(&self) -> f64 {
        let r = DMatrix::from_column_slice(self.residual.len(), 1, self.residual.as_slice());
        self.weigh(&r).column(0).dot(&self.residual)
    }

    /// Best guess of the nuisances.
    pub(crate) fn nuisance(&self) -> SVector<f64, NUISANCES> {
        let projected = self.nuisances.tr_mul(&self.residual);
        self.posterior * SVector::<f64, NUISANCES>::from_fn(|i, _| projected[i])
    }
}

/// One step of expectation and maximisation. The resting place keeps its prior: a constant shift is all but invisible.
/// `free` parameters were fitted to the same strikes.
pub(crate) fn update(spread: &Spread, strikes: &[Evidence], free: usize) -> Spread {
    let n = strikes.len() as f64;
    let variance = spread.camera * spread.camera;
    let mut next = *spread;
    // The mean speed was fitted to the same strikes, as the launch factor; mean angle and clock were not.
    for (i, fitted) in [(0, 1.0), (1, 0.0), (2, 0.0)] {
        let sum: f64 = strikes
            .iter()
            .map(|e| e.nuisance()[i].powi(2) + variance * e.posterior[(i, i)])
            .sum();
        next.nuisance[i] = (sum / (n - fitted).max(1.0)).sqrt().clamp(1e-5, 1.0);
    }
    let (mut sum, mut freedom) = (0.0, -(free as f64));
    for evidence in strikes {
        let b = evidence.nuisance();
        let explained = &evidence.nuisances * DVector::from_column_slice(b.as_slice());
        sum += (&evidence.residual - explained).norm_squared();
        let shrunk: f64 = (0..NUISANCES)
            .map(|i| evidence.posterior[(i, i)] * variance / spread.nuisance[i].powi(2).max(1e-18))
            .sum();
        freedom += evidence.residual.len() as f64 - (NUISANCES as f64 - shrunk);
    }
    next.camera = (sum / freedom.max(1.0)).sqrt().max(1e-6);
    for i in [3, 4] {
        next.nuisance[i] = next.camera / 10f64.sqrt();
    }
    next
}
