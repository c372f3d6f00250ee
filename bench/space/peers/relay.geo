// The relay of docs/examples/own-magnet (here: drawing.geo) with a rim, mesh in m, for gmsh.
Include "drawing.geo";
rim() = CombinedBoundary{ Volume{:}; };
Physical Surface("rim", 10) = rim();
Mesh.ScalingFactor = 0.001;
