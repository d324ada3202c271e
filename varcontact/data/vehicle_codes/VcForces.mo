// Made by varcontact $version. Keep vc_forces.c and vc_forces.h in the folder of this file.
package VcForces "Creep forces of an elliptic contact in steady rolling, from a table of exact solutions"
  function call "vc_forces of vc_forces.c"
    input Real contact[9] "a, b, G, nu, Fz, f, vx, vy, spin";
    output Integer status;
    output Real force[3] "Fx, Fy, Mz";
    external "C" status = vc_forces(contact, force)
      annotation(IncludeDirectory = "modelica://VcForces", Include = "#include \"vc_forces.c\"");
  end call;

  block Forces "Forces on body 1; with SI units for all inputs"
    parameter Real G = 82e9 "combined modulus of rigidity [Pa]";
    parameter Real nu = $nu "combined Poisson's ratio";
    input Real a "semi-axis along the rolling direction [m]";
    input Real b "semi-axis across it [m]";
    input Real Fz "normal force [N]";
    input Real f "coefficient of friction";
    input Real vx "longitudinal creepage";
    input Real vy "lateral creepage";
    input Real spin "[1/m]";
    output Real force[3] "Fx [N], Fy [N], Mz [N m]";
    output Integer status "0; 1 if a/b is outside the table";
  equation
    (status, force) = call({a, b, G, nu, Fz, f, vx, vy, spin});
    assert(status >= 0, "vc_forces: an input is not finite or not positive, or nu is not that of the table");
  end Forces;
end VcForces;
