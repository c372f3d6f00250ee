// Half of a C-core with its coil, for gmsh. outline.pro holds its edges in mm; mesh in m. `size` scales the cells near
// the core.
SetFactory("OpenCASCADE");
DefineConstant[ size = {1, Name "size"} ];
Include "outline.pro";

// iron
Box(1) = {-x1, 0, yoke_bottom, x3 + x1, y1, window_bottom - yoke_bottom};
Box(2) = {-x1, 0, window_bottom, 2 * x1, y1, -window_bottom};
Box(3) = {x2, 0, window_bottom, x3 - x2, y1, window_top - window_bottom};
Box(4) = {-x1, 0, face, 2 * x1, y1, window_top - face};
Box(5) = {-x1, 0, window_top, x3 + x1, y1, yoke_top - window_top};
// gap, coil with what it encloses
Box(6) = {-x1, 0, 0, 2 * x1, y1, face};
Box(7) = {-coil_right, 0, coil_bottom, 2 * coil_right, coil_y2, coil_top - coil_bottom};
Box(8) = {-coil_left, 0, coil_bottom, 2 * coil_left, coil_y1, coil_top - coil_bottom};
Box(20) = {-coil_right - 4 * x3, 0, yoke_bottom - 3 * x3, coil_right + 9 * x3, coil_y2 + 4 * x3,
           yoke_top - yoke_bottom + 6 * x3};
parts() = BooleanFragments{ Volume{20}; Delete; }{ Volume{1 : 8}; Delete; };

e = 0.01;
iron() = Volume In BoundingBox{-x1 - e, -e, yoke_bottom - e, x3 + e, y1 + e, window_bottom + e};
iron() += Volume In BoundingBox{-x1 - e, -e, window_bottom - e, x1 + e, y1 + e, e};
iron() += Volume In BoundingBox{x2 - e, -e, window_bottom - e, x3 + e, y1 + e, window_top + e};
iron() += Volume In BoundingBox{-x1 - e, -e, face - e, x1 + e, y1 + e, window_top + e};
iron() += Volume In BoundingBox{-x1 - e, -e, window_top - e, x3 + e, y1 + e, yoke_top + e};
iron() = Unique(iron());
air() = Volume{:};
air() -= iron();
Physical Volume("iron", 1) = iron();
Physical Volume("air", 2) = air();
rim() = CombinedBoundary{ Volume{:}; };
Physical Surface("rim", 10) = rim();

// sizes: edges of the pole faces, the core, the air
gap() = Volume In BoundingBox{-x1 - e, -e, -e, x1 + e, y1 + e, face + e};
faces() = Boundary{ Volume{gap()}; };
Field[1] = Distance; Field[1].CurvesList = {Boundary{ Surface{faces()}; }}; Field[1].NumPointsPerCurve = 60;
Field[2] = Threshold; Field[2].InField = 1;
Field[2].SizeMin = 0.5 * size; Field[2].SizeMax = 25; Field[2].DistMin = 0.3; Field[2].DistMax = 60;
outside() = Boundary{ Volume{iron()}; };
Field[3] = Distance; Field[3].CurvesList = {Boundary{ Surface{outside()}; }}; Field[3].NumPointsPerCurve = 30;
Field[4] = Threshold; Field[4].InField = 3;
Field[4].SizeMin = 2 * size; Field[4].SizeMax = 25; Field[4].DistMin = 1; Field[4].DistMax = 80;
Field[5] = Box; Field[5].VIn = 3 * size; Field[5].VOut = 25; Field[5].Thickness = 30;
Field[5].XMin = -x1; Field[5].XMax = x3; Field[5].YMin = 0; Field[5].YMax = coil_y2;
Field[5].ZMin = yoke_bottom; Field[5].ZMax = yoke_top;
Field[6] = Min; Field[6].FieldsList = {2, 4, 5};
Background Field = 6;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0; Mesh.MeshSizeMax = 25;
Mesh.Algorithm3D = 10; Mesh.ScalingFactor = 0.001; Mesh.Optimize = 1;
