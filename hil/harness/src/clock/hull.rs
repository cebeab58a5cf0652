//! The lower convex hull of points whose abscissae increase.

/// A point: a sample's index, counted from a reference, and when it arrived, s from a reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Sample index from a reference.
    pub index: f64,
    /// Arrival, s from a reference.
    pub arrival_s: f64,
}

/// Appends `point`, whose index is greater than those of `hull`, and drops what lies above then.
pub fn extend(hull: &mut Vec<Point>, point: Point) {
    while let [.., before, last] = hull.as_slice()
        && !turns_up(*before, *last, point)
    {
        hull.pop();
    }
    hull.push(point);
}

/// Whether `b` lies below the chord from `a` to `c`.
fn turns_up(a: Point, b: Point, c: Point) -> bool {
    let (ab, ac) = (b.index - a.index, c.index - a.index);
    (b.arrival_s - a.arrival_s) * ac < (c.arrival_s - a.arrival_s) * ab
}

/// The edge of `hull` over `index`; the nearest one when `index` is outside, none when there is no
/// edge.
///
/// Over the mean index of all points, that edge is the line below all points with the least sum of
/// distances.
#[must_use]
pub fn edge_over(hull: &[Point], index: f64) -> Option<(Point, Point)> {
    let after = hull.partition_point(|point| point.index <= index);
    let right = after.clamp(1, hull.len().saturating_sub(1).max(1));
    Some((*hull.get(right - 1)?, *hull.get(right)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn hull_of(points: &[Point]) -> Vec<Point> {
        let mut hull = Vec::new();
        points.iter().for_each(|point| extend(&mut hull, *point));
        hull
    }

    #[test]
    fn no_edge_without_two_points() {
        assert_eq!(edge_over(&[], 0.0), None);
        assert_eq!(edge_over(&[Point { index: 0.0, arrival_s: 1.0 }], 0.0), None);
    }

    proptest! {
        /// Small integers, so that the cross products are exact.
        #[test]
        fn no_point_lies_below_the_hull_and_its_vertices_are_points(
            heights in proptest::collection::vec(0_u16..50, 2..60),
        ) {
            let points: Vec<_> = heights
                .iter()
                .enumerate()
                .map(|(k, height)| Point { index: k as f64, arrival_s: f64::from(*height) })
                .collect();
            let hull = hull_of(&points);
            prop_assert!(hull.iter().all(|vertex| points.contains(vertex)));
            for point in &points {
                let (a, b) = edge_over(&hull, point.index).unwrap();
                let above = (point.arrival_s - a.arrival_s) * (b.index - a.index)
                    - (b.arrival_s - a.arrival_s) * (point.index - a.index);
                prop_assert!(above >= 0.0, "{point:?} lies below {a:?} {b:?}");
            }
        }

        #[test]
        fn the_edge_is_the_one_over_the_index(
            heights in proptest::collection::vec(0_u16..50, 3..60),
            share in 0.0..1.0_f64,
        ) {
            let points = heights
                .iter()
                .enumerate()
                .map(|(k, height)| Point { index: k as f64, arrival_s: f64::from(*height) });
            let hull = hull_of(&points.collect::<Vec<_>>());
            let index = share * (heights.len() - 1) as f64;
            let (a, b) = edge_over(&hull, index).unwrap();
            prop_assert!(a.index <= index && index <= b.index);
        }
    }
}
