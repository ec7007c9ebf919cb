//! The points of a large scatter that are drawn: all extreme ones, and every k-th of the others.

/// Indices that are drawn, ascending: all whose `size` is among the largest 1 % or that `keep` names, and of the rest
/// every k-th, so that about `most` are drawn.
pub(crate) fn thin(sizes: &[f64], most: usize, keep: impl Fn(usize) -> bool) -> Vec<usize> {
    if sizes.len() <= most {
        return (0..sizes.len()).collect();
    }
    let from = quantile(sizes.to_vec(), 0.99);
    let stands_out = |k: usize| sizes[k] >= from || keep(k);
    let out = (0..sizes.len()).filter(|&k| stands_out(k)).count();
    let rest = most.saturating_sub(out).max(1);
    let step = (sizes.len() - out).div_ceil(rest).max(1);
    let mut seen = 0usize;
    (0..sizes.len())
        .filter(|&k| {
            if stands_out(k) {
                return true;
            }
            seen += 1;
            (seen - 1).is_multiple_of(step)
        })
        .collect()
}

/// Quantile of the finite values; NaN where there are none.
pub(crate) fn quantile(mut values: Vec<f64>, fraction: f64) -> f64 {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    if values.is_empty() {
        return f64::NAN;
    }
    values[((values.len() - 1) as f64 * fraction).round() as usize]
}

/// A bin of points: weighted mean of x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bin {
    /// Mean of x.
    pub x: f64,
    /// Mean of y.
    pub y: f64,
    /// Standard error of the mean of y, from the scatter in the bin.
    pub error: f64,
    /// Standard deviation of y in the bin.
    pub spread: f64,
    /// Points.
    pub count: usize,
}

/// Means in bins of equal width; empty ones are left out.
pub(crate) fn bins(points: &[(f64, f64, f64)], count: usize) -> Vec<Bin> {
    let low = points.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
    let width = (high - low).max(f64::MIN_POSITIVE);
    let mut parts: Vec<Vec<(f64, f64, f64)>> = vec![Vec::new(); count];
    for p in points.iter().filter(|p| p.1.is_finite() && p.2 > 0.0) {
        let at = ((p.0 - low) / width * count as f64) as usize;
        parts[at.min(count - 1)].push(*p);
    }
    parts
        .iter()
        .filter(|part| !part.is_empty())
        .map(|part| {
            let weight: f64 = part.iter().map(|p| p.2).sum();
            let mean =
                |f: &dyn Fn(&(f64, f64, f64)) -> f64| part.iter().map(|p| p.2 * f(p)).sum::<f64>() / weight;
            let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
            let spread = mean(&|p| (p.1 - y).powi(2)).sqrt();
            // Kish: as many equal weights as would know the mean as well.
            let effective = weight * weight / part.iter().map(|p| p.2 * p.2).sum::<f64>();
            let error = if effective > 1.5 { spread / (effective - 1.0).sqrt() } else { f64::NAN };
            Bin { x, y, error, spread, count: part.len() }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_outliers_are_kept() {
        let sizes: Vec<f64> =
            (0..10_000).map(|k| if k % 1999 == 7 { 9.0 } else { f64::from(k % 10) * 0.1 }).collect();
        let drawn = thin(&sizes, 1000, |k| k == 4242);
        assert!(drawn.len() < 1300 && drawn.contains(&4242));
        assert!((0..10_000).filter(|k| k % 1999 == 7).all(|k| drawn.contains(&k)));
        assert_eq!(thin(&sizes[..50], 100, |_| false).len(), 50);
    }

    #[test]
    fn means_of_bins() {
        let points: Vec<_> = (0..100).map(|k| (f64::from(k), 2.0, 1.0)).collect();
        let bins = bins(&points, 10);
        assert_eq!(bins.len(), 10);
        assert!(bins.iter().all(|b| (b.y - 2.0).abs() < 1e-12 && b.count == 10 && b.error < 1e-9));
    }
}
