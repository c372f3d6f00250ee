// A quarter of an E-core with coil and shading rings, for gmsh. outline.pro holds its edges in mm; mesh in m. `size`
// scales the cells near the core.
SetFactory("OpenCASCADE");
DefineConstant[ size = {1, Name "size"} ];
Include "outline.pro";

// iron
Box(1) = {0, 0, yoke_bottom, x3, y1, window_bottom - yoke_bottom};
Box(2) = {0, 0, window_bottom, x1, y1, -window_bottom};
Box(3) = {x2, 0, window_bottom, slot_left - x2, y1, -window_bottom};
Box(4) = {slot_left, 0, window_bottom, slot_right - slot_left, y1, ring_bottom - window_bottom};
Box(5) = {slot_right, 0, window_bottom, x3 - slot_right, y1, -window_bottom};
Box(6) = {0, 0, face, x1, y1, window_top - face};
Box(7) = {x2, 0, face, x3 - x2, y1, window_top - face};
Box(8) = {0, 0, window_top, x3, y1, yoke_top - window_top};
// gap, coil with what it encloses, ring with what it encloses
Box(9) = {0, 0, 0, x3, y1, face};
Box(10) = {0, 0, coil_bottom, coil_right, coil_y2, coil_top - coil_bottom};
Box(11) = {0, 0, coil_bottom, coil_left, coil_y1, coil_top - coil_bottom};
Box(12) = {ring_left, 0, ring_bottom, slot_right - ring_left, ring_y2, -ring_bottom};
Box(20) = {0, 0, yoke_bottom - 3 * x3, 5 * x3, coil_y2 + 4 * x3, yoke_top - yoke_bottom + 6 * x3};
parts() = BooleanFragments{ Volume{20}; Delete; }{ Volume{1 : 12}; Delete; };

e = 0.01;
iron() = Volume In BoundingBox{-e, -e, yoke_bottom - e, x3 + e, y1 + e, window_bottom + e};
iron() += Volume In BoundingBox{-e, -e, window_bottom - e, x1 + e, y1 + e, e};
iron() += Volume In BoundingBox{x2 - e, -e, window_bottom - e, slot_left + e, y1 + e, e};
iron() += Volume In BoundingBox{slot_left - e, -e, window_bottom - e, slot_right + e, y1 + e, ring_bottom + e};
iron() += Volume In BoundingBox{slot_right - e, -e, window_bottom - e, x3 + e, y1 + e, e};
iron() += Volume In BoundingBox{-e, -e, face - e, x1 + e, y1 + e, window_top + e};
iron() += Volume In BoundingBox{x2 - e, -e, face - e, x3 + e, y1 + e, window_top + e};
iron() += Volume In BoundingBox{-e, -e, window_top - e, x3 + e, y1 + e, yoke_top + e};
iron() = Unique(iron());
air() = Volume{:};
air() -= iron();
Physical Volume("iron", 1) = iron();
Physical Volume("air", 2) = air();
rim() = CombinedBoundary{ Volume{:}; };
Physical Surface("rim", 10) = rim();

// sizes: edges of the pole faces and of the ring, the core, the air
gap() = Volume In BoundingBox{-e, -e, -e, x3 + e, y1 + e, face + e};
ring() = Volume In BoundingBox{ring_left - e, -e, ring_bottom - e, slot_right + e, ring_y2 + e, e};
faces() = Boundary{ Volume{gap(), ring()}; };
Field[1] = Distance; Field[1].CurvesList = {Boundary{ Surface{faces()}; }}; Field[1].NumPointsPerCurve = 60;
Field[2] = Threshold; Field[2].InField = 1;
Field[2].SizeMin = 0.5 * size; Field[2].SizeMax = 25; Field[2].DistMin = 0.3; Field[2].DistMax = 60;
outside() = Boundary{ Volume{iron()}; };
Field[3] = Distance; Field[3].CurvesList = {Boundary{ Surface{outside()}; }}; Field[3].NumPointsPerCurve = 30;
Field[4] = Threshold; Field[4].InField = 3;
Field[4].SizeMin = 2 * size; Field[4].SizeMax = 25; Field[4].DistMin = 1; Field[4].DistMax = 80;
Field[5] = Box; Field[5].VIn = 3 * size; Field[5].VOut = 25; Field[5].Thickness = 30;
Field[5].XMin = 0; Field[5].XMax = x3; Field[5].YMin = 0; Field[5].YMax = coil_y2;
Field[5].ZMin = yoke_bottom; Field[5].ZMax = yoke_top;
Field[6] = Min; Field[6].FieldsList = {2, 4, 5};
Background Field = 6;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0; Mesh.MeshSizeMax = 25;
Mesh.Algorithm3D = 10; Mesh.ScalingFactor = 0.001; Mesh.Optimize = 1;
