//! Least squares: Levenberg and Marquardt, with derivatives by differences.
//!
//! *Invariant:* the sum of squares never grows; the result does not depend on anything but its input.

use nalgebra::{DMatrix, DVector};

/// Most steps.
const STEPS: usize = 60;

/// A step that improves less than this part ends the fit.
const ENOUGH: f64 = 1e-9;

/// The output.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// The parameters.
    pub(crate) values: Vec<f64>,
    /// Their standard errors; none of a parameter that the measurements do not determine.
    pub(crate) errors: Vec<Option<f64>>,
}

/// Finds the parameters at which the squares of `residuals` are least. `step`: a small change of each parameter.
///
/// # Errors
/// Those of `residuals`.
pub(crate) fn fit<E>(
    start: Vec<f64>,
    step: &[f64],
    mut residuals: impl FnMut(&[f64]) -> Result<DVector<f64>, E>,
) -> Result<Fit, E> {
    let mut values = start;
    let mut now = residuals(&values)?;
    let mut damping = 1e-3;
    // Without parameters there is nothing to change, and no matrix to solve.
    let steps = if values.is_empty() { 0 } else { STEPS };
    for _ in 0..steps {
        let slopes = slopes(&values, step, &now, &mut residuals)?;
        let (normal, gradient) = (slopes.tr_mul(&slopes), slopes.tr_mul(&now));
        let mut better = None;
        for _ in 0..12 {
            let mut damped = normal.clone();
            for at in 0..damped.nrows() {
                let diagonal = damped.get((at, at)).copied().unwrap_or(0.0);
                if let Some(slot) = damped.get_mut((at, at)) {
                    *slot = diagonal * (1.0 + damping) + 1e-12;
                }
            }
            let Some(change) = damped.lu().solve(&gradient) else { break };
            let next: Vec<f64> = values.iter().zip(change.iter()).map(|(value, change)| value - change).collect();
            let then = residuals(&next)?;
            if then.norm_squared() < now.norm_squared() {
                better = Some((next, then));
                damping = (damping * 0.3).max(1e-12);
                break;
            }
            damping *= 4.0;
        }
        let Some((next, then)) = better else { break };
        let gain = now.norm_squared() - then.norm_squared();
        (values, now) = (next, then);
        if gain <= ENOUGH * now.norm_squared() {
            break;
        }
    }
    let slopes = slopes(&values, step, &now, &mut residuals)?;
    let errors = errors(&slopes, &now);
    Ok(Fit { values, errors })
}

/// Derivatives of the residuals.
fn slopes<E>(
    values: &[f64],
    step: &[f64],
    now: &DVector<f64>,
    residuals: &mut impl FnMut(&[f64]) -> Result<DVector<f64>, E>,
) -> Result<DMatrix<f64>, E> {
    let mut columns = Vec::with_capacity(values.len());
    for (at, by) in step.iter().enumerate() {
        let mut moved = values.to_vec();
        if let Some(slot) = moved.get_mut(at) {
            *slot += by;
        }
        columns.push((residuals(&moved)? - now) / *by);
    }
    Ok(if columns.is_empty() { DMatrix::zeros(now.len(), 0) } else { DMatrix::from_columns(&columns) })
}

/// Standard errors of the parameters from the spread of the residuals.
fn errors(slopes: &DMatrix<f64>, left: &DVector<f64>) -> Vec<Option<f64>> {
    let (rows, columns) = slopes.shape();
    let freedom = rows.saturating_sub(columns);
    let nothing = vec![None; columns];
    if freedom == 0 || columns == 0 {
        return nothing;
    }
    let variance = left.norm_squared() / freedom as f64;
    let norms: Vec<f64> = slopes.column_iter().map(|column| column.norm()).collect();
    let used: Vec<usize> = (0..columns).filter(|at| norms.get(*at).is_some_and(|norm| *norm > 1e-9)).collect();
    let scaled: Vec<DVector<f64>> = used.iter().map(|at| slopes.column(*at).normalize()).collect();
    if scaled.is_empty() {
        return nothing;
    }
    let parts = DMatrix::from_columns(&scaled).svd(false, true);
    let Some(directions) = parts.v_t else { return nothing };
    let mut errors = nothing;
    for (place, at) in used.iter().enumerate() {
        let shares = directions.column(place);
        // A parameter in a direction that changes nothing acts only together with others.
        let together =
            shares.iter().zip(&parts.singular_values).any(|(share, size)| *size < 1e-6 && share.abs() > 1e-3);
        let sum: f64 = shares
            .iter()
            .zip(&parts.singular_values)
            .filter(|(_, size)| **size >= 1e-6)
            .map(|(v, s)| (v / s).powi(2))
            .sum();
        let norm = norms.get(*at).copied().unwrap_or(1.0);
        let error = (sum * variance).sqrt() / norm;
        if let Some(slot) = errors.get_mut(*at).filter(|_| !together && error.is_finite()) {
            *slot = Some(error);
        }
    }
    errors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_found_again() {
        let points: Vec<f64> = (0..30).map(|at| f64::from(at) * 0.1).collect();
        let curve = |a: f64, b: f64, x: f64| a * (-b * x).exp();
        let residuals = |values: &[f64]| {
            let [a, b] = [values[0], values[1]];
            let left = points.iter().map(|x| curve(a, b, *x) - curve(3.0, 0.7, *x));
            Ok::<_, ()>(DVector::from_iterator(points.len(), left))
        };
        let fit = fit(vec![1.0, 0.1], &[1e-6, 1e-6], residuals).unwrap();
        assert!((fit.values[0] - 3.0).abs() < 1e-5 && (fit.values[1] - 0.7).abs() < 1e-5, "{fit:?}");
        assert!(fit.errors.iter().all(Option::is_some));
    }

    #[test]
    fn what_the_measurements_do_not_say_stays() {
        let residuals = |values: &[f64]| Ok::<_, ()>(DVector::from_vec(vec![values[0] - 2.0, values[0] - 2.2]));
        let fit = fit(vec![1.0, 5.0], &[1e-6, 1e-6], residuals).unwrap();
        assert!((fit.values[0] - 2.1).abs() < 1e-6);
        assert_eq!(fit.values[1], 5.0);
        assert_eq!(fit.errors[1], None);
    }

    #[test]
    fn few_measurements_are_no_mistake() {
        let none = fit(Vec::new(), &[], |_| Ok::<_, ()>(DVector::from_vec(vec![1.0, 2.0]))).unwrap();
        assert!(none.values.is_empty() && none.errors.is_empty());
        let one = |values: &[f64]| Ok::<_, ()>(DVector::from_vec(vec![values[0] + values[1] - 2.0]));
        let fit = fit(vec![0.0, 0.0], &[1e-6, 1e-6], one).unwrap();
        assert!((fit.values[0] + fit.values[1] - 2.0).abs() < 1e-6);
        assert_eq!(fit.errors, [None, None]);
    }
}
